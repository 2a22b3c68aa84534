"""ISA-95 Job Control, as asyncua's own client sees it: a server before a cell in virtual time."""

from __future__ import annotations

import asyncio
import json
import time
from collections.abc import Awaitable, Callable, Iterator
from datetime import datetime, timedelta, timezone
from pathlib import Path
from typing import Any

import asyncua
import pytest
from asyncua import ua
from opcua_reader import Reader, client_of
from opcua_stand import PATIENCE_S, opcua_stand, served
from web.stand_cell import StandCell

from bt_orchestrator.model.jobs.order import WorkOrder
from bt_orchestrator.store.memory import MemoryStore

DONE, UNKNOWN, WRONG, NOT_ACCEPTED, MALFORMED = 1, 2, 8, 16, 1 << 32
COMMENT = [ua.LocalizedText('a test', 'en')]


class Mes(Reader):
    """An MES."""

    def __init__(self, client: asyncua.Client, idx: int) -> None:
        super().__init__(client, idx)
        self.heard: list[Any] = []

    async def send(
        self, path: str, *given: ua.Variant, on: ua.NodeId | None = None
    ) -> tuple[ua.StatusCode, list[Any]]:
        """Call a method; returns status and outputs, which asyncua keeps back unless Good."""
        request = ua.CallMethodRequest()
        request.ObjectId = on or self.node(path.rpartition('/')[0]).nodeid
        request.MethodId = self.node(path).nodeid
        request.InputArguments = list(given)
        (result,) = await self.client.uaclient.call([request])
        return result.StatusCode, [one.Value for one in result.OutputArguments or ()]

    async def method(self, name: str, what: object, comment: Any = COMMENT) -> int:
        """Call a method of the receiver; a failure has to carry Uncertain."""
        is_id = isinstance(what, str)
        type_ = ua.VariantType.String if is_id else ua.VariantType.ExtensionObject
        text = ua.Variant(comment, ua.VariantType.LocalizedText, is_array=True)
        code, outputs = await self.send(f'JobOrderControl/{name}', ua.Variant(what, type_), text)
        (status,) = outputs
        assert code.is_good() if status == DONE else code.is_uncertain(), (code, status)
        return int(status)

    async def listed(self) -> dict[str, Any]:
        return {
            one.JobOrder.JobOrderID: one
            for one in await self.value('JobOrderControl/JobOrderList')
        }

    async def wait_for(self, job: str, *states: str) -> Any:
        """Wait until a job is listed in a state."""
        deadline = time.monotonic() + PATIENCE_S
        while True:
            found = (await self.listed()).get(job)
            is_now = [] if found is None else [one.StateText.Text for one in found.State]
            if is_now == list(states):
                return found
            assert time.monotonic() < deadline, f'{job} is {is_now}'
            await asyncio.sleep(0.05)

    async def response(self, job: str) -> Any:
        code, (response, status) = await self.send(
            'JobOrderResults/RequestJobResponseByJobOrderID',
            ua.Variant(job, ua.VariantType.String),
        )
        assert (code.is_good(), status) == (True, DONE)
        return response

    async def listen(self, node: asyncua.Node) -> None:
        """Hear the events of a node."""
        subscription = await self.client.create_subscription(50, self)
        types = [
            ua.NodeId('JobOrderChangedEventType', self.idx),
            ua.NodeId('RequestRefusedEventType', self.idx),
        ]
        await subscription.subscribe_events(node, types)

    def event_notification(self, event: Any) -> None:
        self.heard.append(event)

    async def heard_of(self, is_it: Callable[[Any], bool], number: int = 1) -> list[Any]:
        deadline = time.monotonic() + PATIENCE_S
        while len(found := [one for one in self.heard if is_it(one)]) < number:
            assert time.monotonic() < deadline, [one.Message.Text for one in self.heard]
            await asyncio.sleep(0.05)
        return found


def parameter(name: str, value: object, type_: ua.VariantType) -> Any:
    is_array = isinstance(value, list)
    return ua.ISA95ParameterDataType(ID=name, Value=ua.Variant(value, type_, is_array=is_array))


def order(id_: str, script: str, runs: int = 1, **fields: Any) -> Any:
    runs_planned = parameter('RunsPlanned', runs, ua.VariantType.UInt32)
    more = fields.pop('parameters', [])
    return ua.ISA95JobOrderDataType(
        JobOrderID=id_,
        WorkMasterID=[ua.ISA95WorkMasterDataType(ID=script)],
        JobOrderParameters=[runs_planned, *more],
        **fields,
    )


def data(response: Any) -> dict[str, Any]:
    return {one.ID: one.Value.Value for one in response.JobResponseData}


def with_mes(url: str, what: Callable[[Mes], Awaitable[None]]) -> None:
    async def connected() -> None:
        async with client_of(url) as client:
            await client.load_data_type_definitions()
            mes = await Mes.of(client)
            assert isinstance(mes, Mes)
            await what(mes)

    asyncio.run(connected())


@pytest.fixture(scope='module')
def line(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[StandCell, str]]:
    """One line for all tests that leave it as it was: nothing on it, nothing in its queue."""
    with opcua_stand(tmp_path_factory.mktemp('stand')) as (cell, server):
        yield cell, server.address


@pytest.fixture
def script(line: tuple[StandCell, str]) -> str:
    return line[0].script


@pytest.fixture
def url(line: tuple[StandCell, str]) -> str:
    return line[1]


def test_an_order_is_stored_started_made_and_cleared(script: str, url: str) -> None:
    async def look(mes: Mes) -> None:
        await mes.listen(mes.client.nodes.server)
        assert await mes.method('Store', order('WO-7', script, 2)) == DONE
        await mes.wait_for('WO-7', 'NotAllowedToStart')
        assert await mes.method('Start', 'WO-7') == DONE
        ended = await mes.wait_for('WO-7', 'Ended')
        assert script == ended.JobOrder.WorkMasterID[0].ID
        response = await mes.response('WO-7')
        found = data(response)
        assert (found['GoodQuantity'], found['RunsCompleted'], found['JobResult']) == (2.0, 2, 1)
        assert response.EndTime > response.StartTime
        (last,) = await mes.heard_of(lambda one: one.Message.Text.startswith('WO-7 is Ended'))
        assert data(last.JobResponse) == found
        assert last.JobState[0].StateNumber == 5
        assert last.JobOrder.JobOrderID == 'WO-7'
        told = [one.JobState[0].StateText.Text for one in mes.heard]
        assert told == ['NotAllowedToStart', 'AllowedToStart', 'Running', 'Ended']
        shown = await mes.value('JobOrderResults/JobOrderResponseList')
        assert [data(one) for one in shown if one.JobOrderID == 'WO-7'] == [found]
        assert await mes.method('Clear', 'WO-7') == DONE
        assert await mes.method('Clear', 'WO-7') == UNKNOWN
        assert await mes.method('Store', order('WO-7', script)) == NOT_ACCEPTED, 'used once'

    with_mes(url, look)


def test_items_and_events_are_pulled(script: str, url: str) -> None:
    text, number = ua.VariantType.String, ua.VariantType.UInt32

    async def items(mes: Mes, after: str, most: int) -> tuple[ua.StatusCode, list[Any]]:
        given = ua.Variant('IT-1', text), ua.Variant(after, text), ua.Variant(most, number)
        return await mes.send('JobOrderResults/GetItems', *given)

    async def look(mes: Mes) -> None:
        assert await mes.method('StoreAndStart', order('IT-1', script, 3)) == DONE
        await mes.wait_for('IT-1', 'Ended')
        _, (first, is_last, is_whole) = await items(mes, '', 2)
        assert [json.loads(one)['item'] for one in first] == ['IT-1/1', 'IT-1/2']
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
        assert [json.loads(one)['seq'] for one in events] == [1, 2, 3, 4, 5]
        assert last > 5
        assert history

    with_mes(url, look)


def test_what_is_wrong_with_an_order_is_a_status_and_an_event(script: str, url: str) -> None:
    async def look(mes: Mes) -> None:
        await mes.listen(mes.node('JobOrderControl'))
        unknown = parameter('nonsense', 1, ua.VariantType.Int64)
        for wrong, status, said in (
            (order('', script), MALFORMED, 'JobOrderID'),
            (order('a/b', script), MALFORMED, 'slash'),
            (order('X-1', 'no_such_script'), NOT_ACCEPTED, 'no_such_script'),
            (order('X-1', script, parameters=[unknown]), NOT_ACCEPTED, 'nonsense'),
            (order('X-1', 'WM-100'), NOT_ACCEPTED, 'recipe'),
            (order('X-1', script, 0), NOT_ACCEPTED, 'RunsPlanned'),
            (ua.ISA95JobOrderDataType(JobOrderID='X-1'), NOT_ACCEPTED, 'exactly one'),
            (ua.EUInformation(), MALFORMED, 'ISA95JobOrderDataType'),
        ):
            assert await mes.method('StoreAndStart', wrong) == status
            await mes.heard_of(lambda one: said in f'{one.Message.Text} {one.Findings}')  # noqa: B023
        assert 'X-1' not in await mes.listed()
        for name in (
            'Start',
            'RevokeStart',
            'Pause',
            'Resume',
            'Stop',
            'Abort',
            'Cancel',
            'Clear',
        ):
            assert await mes.method(name, 'NO-1') == UNKNOWN
            assert await mes.method(name, '') == MALFORMED
        assert await mes.method('Update', order('NO-1', script)) == UNKNOWN
        refused = await mes.heard_of(lambda one: one.Method == 'Update')
        assert (refused[0].JobOrderID, refused[0].ReturnStatus) == ('NO-1', UNKNOWN)

    with_mes(url, look)


def test_what_was_done_can_be_read_at_once(script: str, url: str) -> None:
    async def look(mes: Mes) -> None:
        for number in range(5):
            name = f'AT-{number}'
            assert await mes.method('Store', order(name, script)) == DONE
            assert name in await mes.listed()
            assert await mes.method('Cancel', name) == DONE
            assert name not in await mes.listed()

    with_mes(url, look)


def test_an_order_given_twice_is_made_once(script: str, url: str) -> None:
    async def look(mes: Mes) -> None:
        assert await mes.method('Store', order('TW-1', script, 2)) == DONE
        assert await mes.method('StoreAndStart', order('TW-1', script, 2)) == NOT_ACCEPTED
        await mes.wait_for('TW-1', 'NotAllowedToStart')
        assert await mes.method('Cancel', 'TW-1') == DONE

    with_mes(url, look)


def test_a_client_may_name_the_method_of_the_type(url: str) -> None:
    async def look(mes: Mes) -> None:
        uris = await mes.client.get_namespace_array()
        declared = ua.NodeId(7011, uris.index('http://opcfoundation.org/UA/ISA95-JOBCONTROL_V2/'))
        request = ua.CallMethodRequest()
        request.ObjectId, request.MethodId = mes.node('JobOrderControl').nodeid, declared
        request.InputArguments = [ua.Variant('NO-1', ua.VariantType.String), ua.Variant()]
        (result,) = await mes.client.uaclient.call([request])
        assert [one.Value for one in result.OutputArguments] == [UNKNOWN]

    with_mes(url, look)


def test_an_order_is_changed_and_told_as_it_is(script: str, url: str) -> None:
    names = [
        parameter('Customers', ['ACME'], ua.VariantType.String),
        parameter('JobName', [ua.LocalizedText('Batch', 'en')], ua.VariantType.LocalizedText),
    ]
    material = ua.ISA95MaterialDataType(MaterialDefinitionID='M-1', Quantity='40')

    async def look(mes: Mes) -> None:
        given = order(
            'UP-1',
            script,
            4,
            Priority=3,
            Description=[ua.LocalizedText('For ACME', 'en')],
            MaterialRequirements=[material],
            parameters=names,
        )
        assert await mes.method('Store', given) == DONE
        told = (await mes.wait_for('UP-1', 'NotAllowedToStart')).JobOrder
        assert told.Description == given.Description
        assert told.Priority == 3
        assert told.MaterialRequirements == [material]
        assert {one.ID: one.Value for one in told.JobOrderParameters} == {
            one.ID: one.Value for one in given.JobOrderParameters
        }
        told.JobOrderParameters[0].Value = ua.Variant(6, ua.VariantType.UInt32)
        told.Priority = 9
        await mes.listen(mes.node('JobOrderResults'))
        assert await mes.method('Update', told) == DONE
        (changed,) = await mes.heard_of(lambda one: one.Message.Text == 'UP-1 was changed')
        assert changed.JobOrder == told
        assert changed.JobState[0].StateText.Text == 'NotAllowedToStart'
        assert (await mes.listed())['UP-1'].JobOrder == told
        assert await mes.method('Cancel', 'UP-1') == DONE

    with_mes(url, look)


def test_a_job_on_the_line_is_paused_resumed_and_stopped(script: str, url: str) -> None:
    async def look(mes: Mes) -> None:
        await mes.listen(mes.node('JobOrderResults'))
        assert await mes.method('StoreAndStart', order('ST-1', script, 200)) == DONE
        await mes.wait_for('ST-1', 'Running')
        assert await mes.method('Start', 'ST-1') == WRONG
        assert await mes.method('Pause', 'ST-1') == DONE
        paused = await mes.wait_for('ST-1', 'Interrupted', 'Suspended')
        assert paused.State[1].BrowsePath.Elements[0].TargetName.Name == 'InterruptedSubstates'
        found = await mes.client.uaclient.translate_browsepaths_to_nodeids(
            [ua.BrowsePath(ua.NodeId('JobOrderControl', mes.idx), paused.State[1].BrowsePath)]
        )
        assert found[0].StatusCode.is_good()
        assert await mes.method('Resume', 'ST-1') == DONE
        assert await mes.method('Stop', 'ST-1', comment=[]) == DONE
        assert await mes.method('Stop', 'ST-1') == WRONG
        await mes.wait_for('ST-1', 'Ended')
        response = data(await mes.response('ST-1'))
        assert response['JobResult'] == 2
        assert response['ReasonForStateChange'].Text == (
            'stand decided stop: no comment (OPC UA Stop)'
        )
        endings = [data(one.JobResponse).get('Ending') for one in mes.heard]
        assert None in endings
        assert await mes.method('Clear', 'ST-1') == DONE

    with_mes(url, look)


def test_a_job_waits_for_its_start(script: str, url: str) -> None:
    async def look(mes: Mes) -> None:
        later = datetime.now(timezone.utc) + timedelta(days=365)
        given = order('LA-1', script, StartTime=later)
        await mes.listen(mes.node('JobOrderResults'))
        assert await mes.method('StoreAndStart', given) == DONE
        told = await mes.wait_for('LA-1', 'AllowedToStart', 'Waiting')
        assert told.JobOrder.StartTime == later
        assert await mes.method('Start', 'LA-1') == DONE
        await mes.heard_of(lambda one: 'waits for its start no more' in one.Message.Text)
        await mes.wait_for('LA-1', 'Ended')

    with_mes(url, look)


def test_responses_are_found_by_state(script: str, url: str) -> None:
    async def by_state(mes: Mes, *states: Any) -> tuple[list[str], int]:
        given = ua.Variant(list(states), ua.VariantType.ExtensionObject, is_array=True)
        path = 'JobOrderResults/RequestJobResponseByJobOrderState'
        _, (found, status) = await mes.send(path, given)
        return [one.JobOrderID for one in found], status

    async def look(mes: Mes) -> None:
        assert await mes.method('StoreAndStart', order('BY-1', script)) == DONE
        await mes.wait_for('BY-1', 'Ended')
        ended = ua.ISA95StateDataType(StateNumber=5)
        found, status = await by_state(mes, ended)
        assert 'BY-1' in found
        assert status == DONE
        assert await by_state(mes, ua.ISA95StateDataType(StateNumber=3)) == ([], DONE)
        assert await by_state(mes, ua.ISA95StateDataType(StateNumber=77)) == ([], WRONG)
        assert await by_state(mes) == ([], MALFORMED)

    with_mes(url, look)


def test_work_masters_and_limits_are_told(script: str, url: str) -> None:
    async def look(mes: Mes) -> None:
        masters = {one.ID: one for one in await mes.value('JobOrderControl/WorkMaster')}
        assert script in masters
        assert masters['GM-37'].Description.Text.startswith('recipe, version ')
        assert [one.ID for one in masters['WM-100'].Parameters] == ['label']
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


def test_all_comes_back_from_the_journal_of_the_node(tmp_path: Path) -> None:
    stand = StandCell(tmp_path, MemoryStore(), faults=(), speed=20.0)
    given: list[Any] = []

    async def give(mes: Mes) -> None:
        names = [parameter('CustomerOrderNumbers', ['C-1', 'C-2'], ua.VariantType.String)]
        text = [ua.LocalizedText('For ACME', 'en')]
        one = order('WO-1', stand.script, 3, Priority=7, Description=text, parameters=names)
        assert await mes.method('StoreAndStart', order('WO-0', stand.script)) == DONE
        assert await mes.method('Store', one) == DONE
        await mes.wait_for('WO-0', 'Ended')
        given.append((await mes.wait_for('WO-1', 'NotAllowedToStart'), await mes.response('WO-0')))

    async def look(mes: Mes) -> None:
        await mes.listen(mes.client.nodes.server)
        assert set(await mes.listed()) == {'WO-0', 'WO-1'}, 'known before the port is open'
        found = await mes.wait_for('WO-1', 'NotAllowedToStart'), await mes.response('WO-0')
        assert found == given[0]
        assert await mes.method('Cancel', 'WO-1') == DONE
        assert not mes.heard, 'what was before is not told again'

    with served(stand) as server:
        with_mes(server.address, give)
    stand.switch()
    stand.switch()
    with served(stand) as server:
        with_mes(server.address, look)


def test_orders_of_other_doors_are_told_too(url: str, line: tuple[StandCell, str]) -> None:
    async def look(mes: Mes) -> None:
        made = line[0].queue(WorkOrder(line[0].script, 'YAML-1', 1))
        assert made.accepted
        listed = await mes.wait_for('YAML-1', 'Ended')
        assert listed.JobOrder.JobOrderParameters[0].Value.Value == 1

    with_mes(url, look)


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
            told = await mes.wait_for('WO-1', 'NotAllowedToStart')
            assert told.JobOrder.Priority == 2
            assert await mes.method('Cancel', 'WO-1') == DONE
            heard = await mes.heard_of(lambda one: one.JobOrder.JobOrderID == 'WO-1', 2)
            assert [one.JobOrder.Priority for one in heard] == [1, 2]

        with_mes(server.address, look)
