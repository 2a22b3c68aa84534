"""What ISA-95 tells of jobs that ended, of their items, and of what can be ordered."""

from __future__ import annotations

import json
from typing import Any

from asyncua import ua
from opcua_mes import DONE, MALFORMED, WRONG, Mes, order, with_mes


def test_items_and_events_are_pulled(script: str, url: str) -> None:
    text, number = ua.VariantType.String, ua.VariantType.UInt32

    async def items(mes: Mes, after: str, most: int) -> tuple[ua.StatusCode, list[Any]]:
        given = ua.Variant('IT-1', text), ua.Variant(after, text), ua.Variant(most, number)
        return await mes.send('JobOrderResults/GetItems', *given)

    async def look(mes: Mes) -> None:
        assert await mes.method('StoreAndStart', order('IT-1', script, 3)) == DONE
        await mes.wait_for('IT-1', 'Ended')
        _, (first, is_last, is_whole) = await items(mes, '', 2)
        assert [json.loads(record)['item'] for record in first] == ['IT-1/1', 'IT-1/2']
        assert (is_last, is_whole) == (False, True)
        _, (rest, is_last, _) = await items(mes, 'IT-1/2', 0)
        assert json.loads(rest[0])['how'] == 'packed'
        assert is_last
        code, _ = await items(mes, 'IT-1/99', 0)
        assert code.value == ua.StatusCodes.BadInvalidArgument
        given = ua.Variant(0, ua.VariantType.UInt64), ua.Variant(5, number)
        cell = await mes.node('JobOrderResults').get_parent()
        code, outputs = await mes.send('GetEvents', *given, on=cell.nodeid)
        assert code.is_good()
        events, last, history = outputs
        assert [json.loads(record)['seq'] for record in events] == [1, 2, 3, 4, 5]
        assert last > 5
        assert history

    with_mes(url, look)


def test_events_are_followed_page_by_page(script: str, url: str) -> None:
    async def page(mes: Mes, after: int, *history: str) -> list[Any]:
        given = [ua.Variant(after, ua.VariantType.UInt64), ua.Variant(3, ua.VariantType.UInt32)]
        given += [ua.Variant(text, ua.VariantType.String) for text in history]
        cell = await mes.node('JobOrderResults').get_parent()
        code, outputs = await mes.send('GetEvents', *given, on=cell.nodeid)
        assert code.is_good()
        return [[json.loads(text)['seq'] for text in outputs[0]], *outputs[1:]]

    async def look(mes: Mes) -> None:
        assert await mes.method('Store', order('EV-1', script)) == DONE
        assert await mes.method('Cancel', 'EV-1') == DONE
        seqs, next_seq, history, is_last = [], 0, '', False
        while not is_last:
            events, last, history, next_seq, is_last = await page(mes, next_seq, history)
            assert events[-1] == next_seq
            seqs += events
        assert seqs == list(range(1, last + 1))
        assert await page(mes, last, history) == [[], last, history, last, True]
        other, *_ = await page(mes, last, 'another journal')
        assert other == [1, 2, 3], 'it begins with the first event of the journal that there is'

    with_mes(url, look)


def test_events_call_without_history_keeps_old_answer(url: str) -> None:
    async def look(mes: Mes) -> None:
        cell = await mes.node('JobOrderResults').get_parent()
        given = ua.Variant(0, ua.VariantType.UInt64), ua.Variant(2, ua.VariantType.UInt32)
        code, outputs = await mes.send('GetEvents', *given, on=cell.nodeid)
        assert code.is_good()
        assert len(outputs) == 3
        code, _ = await mes.send('GetEvents', given[0], on=cell.nodeid)
        assert code.value == ua.StatusCodes.BadArgumentsMissing

    with_mes(url, look)


def test_responses_are_found_by_state(script: str, url: str) -> None:
    async def by_state(mes: Mes, *states: Any) -> tuple[list[str], int]:
        given = ua.Variant(list(states), ua.VariantType.ExtensionObject, is_array=True)
        path = 'JobOrderResults/RequestJobResponseByJobOrderState'
        _, (jobs, status) = await mes.send(path, given)
        return [response.JobOrderID for response in jobs], status

    async def look(mes: Mes) -> None:
        assert await mes.method('StoreAndStart', order('BY-1', script)) == DONE
        await mes.wait_for('BY-1', 'Ended')
        ended = ua.ISA95StateDataType(StateNumber=5)
        jobs, status = await by_state(mes, ended)
        assert 'BY-1' in jobs
        assert status == DONE
        assert await by_state(mes, ua.ISA95StateDataType(StateNumber=3)) == ([], DONE)
        assert await by_state(mes, ua.ISA95StateDataType(StateNumber=77)) == ([], WRONG)
        assert await by_state(mes) == ([], MALFORMED)

    with_mes(url, look)


def test_work_masters_and_limits_are_told(script: str, url: str) -> None:
    async def look(mes: Mes) -> None:
        masters = {entry.ID: entry for entry in await mes.value('JobOrderControl/WorkMaster')}
        assert script in masters
        assert masters['GM-37'].Description.Text.startswith('recipe, version ')
        assert [entry.ID for entry in masters['WM-100'].Parameters] == ['label']
        assert await mes.value('JobOrderControl/MaxDownloadableJobOrders') == 100
        assert 'conveyor' in await mes.value('JobOrderControl/EquipmentID')
        assert await mes.value('JobOrderControl/PersonnelID') == []
        meaning = await mes.node('JobOrderControl/Stop').read_description()
        assert meaning.Text.startswith('end a job early')
        state = await mes.node('JobOrderControl/CurrentState').read_data_value(
            raise_on_bad_status=False
        )
        assert state.StatusCode.value == ua.StatusCodes.BadStateNotActive

    with_mes(url, look)
