"""The states of a job of ISA-95: on the line, waiting, and after a restart."""

from __future__ import annotations

import asyncio
import time
from datetime import datetime, timedelta, timezone
from pathlib import Path
from typing import Any

from asyncua import ua
from opcua_mes import DONE, WRONG, Mes, data, order, parameter, with_mes
from opcua_stand import opcua_stand, served
from patience import PATIENCE_S
from web.stand_cell import StandCell

from bt_orchestrator.store.memory import MemoryStore


def test_running_job_is_paused_resumed_and_stopped(script: str, url: str) -> None:
    async def look(mes: Mes) -> None:
        await mes.listen(mes.node('JobOrderResults'))
        assert await mes.method('StoreAndStart', order('ST-1', script, 200)) == DONE
        await mes.wait_for('ST-1', 'Running')
        assert await mes.method('Start', 'ST-1') == WRONG
        assert await mes.method('Pause', 'ST-1') == DONE
        paused = await mes.wait_for('ST-1', 'Interrupted', 'Suspended')
        assert paused.State[1].BrowsePath.Elements[0].TargetName.Name == 'InterruptedSubstates'
        targets = await mes.client.uaclient.translate_browsepaths_to_nodeids(
            [ua.BrowsePath(ua.NodeId('JobOrderControl', mes.idx), paused.State[1].BrowsePath)]
        )
        assert targets[0].StatusCode.is_good()
        assert await mes.method('Resume', 'ST-1') == DONE
        assert await mes.method('Stop', 'ST-1', comment=[]) == DONE
        assert await mes.method('Stop', 'ST-1') == WRONG
        await mes.wait_for('ST-1', 'Ended')
        response = data(await mes.response('ST-1'))
        assert response['JobResult'] == 2
        assert response['ReasonForStateChange'].Text == (
            'stand decided stop: no comment (OPC UA Stop)'
        )
        endings = [data(event.JobResponse).get('Ending') for event in mes.heard]
        assert None in endings
        assert await mes.method('Clear', 'ST-1') == DONE

    with_mes(url, look)


def test_last_calendar_day_means_no_start(script: str, url: str) -> None:
    async def look(mes: Mes) -> None:
        never = datetime(9999, 12, 31, 23, 59, 59, tzinfo=timezone.utc)
        given = order('NE-1', script, StartTime=never, EndTime=never)
        assert await mes.method('StoreAndStart', given) == DONE
        ended = await mes.wait_for('NE-1', 'Ended')
        assert ended.JobOrder.StartTime is None
        assert ended.JobOrder.EndTime is None

    with_mes(url, look)


def test_a_job_waits_for_its_start(script: str, url: str) -> None:
    async def look(mes: Mes) -> None:
        later = datetime.now(timezone.utc) + timedelta(days=365)
        given = order('LA-1', script, StartTime=later)
        await mes.listen(mes.node('JobOrderResults'))
        assert await mes.method('StoreAndStart', given) == DONE
        waiting = await mes.wait_for('LA-1', 'AllowedToStart', 'Waiting')
        assert waiting.JobOrder.StartTime == later
        assert await mes.method('Start', 'LA-1') == DONE
        await mes.heard_of(lambda event: 'no longer waits for its start' in event.Message.Text)
        await mes.wait_for('LA-1', 'Ended')

    with_mes(url, look)


def test_jobs_are_restored_from_node_journal(tmp_path: Path) -> None:
    stand = StandCell(tmp_path, MemoryStore(), faults=(), speed=20.0)
    given: list[Any] = []

    async def give(mes: Mes) -> None:
        names = [parameter('CustomerOrderNumbers', ['C-1', 'C-2'], ua.VariantType.String)]
        text = [ua.LocalizedText('For ACME', 'en')]
        stored = order('WO-1', stand.script, 3, Priority=7, Description=text, parameters=names)
        assert await mes.method('StoreAndStart', order('WO-0', stand.script)) == DONE
        assert await mes.method('Store', stored) == DONE
        await mes.wait_for('WO-0', 'Ended')
        given.append((await mes.wait_for('WO-1', 'NotAllowedToStart'), await mes.response('WO-0')))

    async def look(mes: Mes) -> None:
        await mes.listen(mes.client.nodes.server)
        assert set(await mes.listed()) == {'WO-0', 'WO-1'}, 'known before the port is open'
        restored = await mes.wait_for('WO-1', 'NotAllowedToStart'), await mes.response('WO-0')
        assert restored == given[0]
        assert await mes.method('Cancel', 'WO-1') == DONE
        assert not mes.heard, 'what was before is not told again'

    with served(stand) as server:
        with_mes(server.address, give)
    stand.switch()
    stand.switch()
    with served(stand) as server:
        with_mes(server.address, look)


def test_another_journal_begins_with_its_own_jobs(tmp_path: Path) -> None:
    with opcua_stand(tmp_path) as (stand, server):

        async def look(mes: Mes) -> None:
            await mes.listen(mes.node('JobOrderResults'))
            assert await mes.method('Store', order('WO-1', stand.script, 2, Priority=1)) == DONE
            await mes.wait_for('WO-1', 'NotAllowedToStart')
            await asyncio.to_thread(stand.begin_anew, stand.cell)
            deadline = time.monotonic() + PATIENCE_S
            while await mes.listed():
                assert time.monotonic() < deadline
                await asyncio.sleep(0.05)
            again = order('WO-1', stand.script, 3, Priority=2)
            assert await mes.method('Store', again) == DONE
            stored = await mes.wait_for('WO-1', 'NotAllowedToStart')
            assert stored.JobOrder.Priority == 2
            assert await mes.method('Cancel', 'WO-1') == DONE
            heard = await mes.heard_of(lambda event: event.JobOrder.JobOrderID == 'WO-1', 2)
            assert [event.JobOrder.Priority for event in heard] == [1, 2]

        with_mes(server.address, look)
