"""The flat part, as asyncua's own client sees it: a server before a cell in virtual time."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import asyncua
import pytest
from asyncua import ua
from fakes import shipped
from fakes.statuses import NOW_S, hold, job, status
from opcua_reader import Reader, reading
from opcua_stand import opcua_stand
from web.stand_cell import FAIL, StandCell

from bt_orchestrator.extensions.opcua.server import simple
from bt_orchestrator.extensions.opcua.server.simple_commands import (
    ANSWER_HOLD,
    COMMAND,
    COMPONENT_COMMAND,
    SUBMIT_ORDER,
)
from bt_orchestrator.script.shifts.shifts_file import read_reasons

REASONS = read_reasons(shipped.REASONS)


class Scene(NamedTuple):
    cell: StandCell
    url: str

    def events(self, kind: str) -> list[Any]:
        """Return what is on record of one kind."""
        with self.cell.lock:
            return [event for event in self.cell.store.read() if event.event == kind]


@pytest.fixture(scope='module')
def scene(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Scene]:
    """One cell for all; each test has jobs of its own, and leaves the line empty."""
    with opcua_stand(tmp_path_factory.mktemp('stand'), faults=[FAIL]) as (cell, server):
        yield Scene(cell, server.address)


async def submit(reader: Reader, *order: Any) -> Any:
    return await reader.call('Simple/SubmitOrder', *order)


def count(number: int) -> ua.Variant:
    return ua.Variant(number, ua.VariantType.UInt32)


def texts(*lines: str) -> ua.Variant:
    return ua.Variant(list(lines), ua.VariantType.String)


def order(id_: str, quantity: int = 1, *parameters: str) -> tuple[Any, ...]:
    return id_, 'inspect_and_assemble', count(quantity), texts(*parameters)


def test_a_held_job_is_seen_answered_and_ends(scene: Scene) -> None:
    """The first job meets the fault."""

    async def look(reader: Reader) -> None:
        assert await reader.value('Simple/Connected') is True
        assert await reader.value('Simple/CurrentJob/ID') == ''
        assert (await submit(reader, *order('WO-1', 4)))[0] is True
        await reader.wait('Simple/CurrentJob/ID', lambda entry: entry == 'WO-1')
        assert await reader.value('Simple/CurrentJob/Planned') == 4
        hold = await reader.wait('Simple/OldestHold/ID', bool)
        assert await reader.value('Simple/OldestHold/Job') == 'WO-1'
        answers = await reader.value('Simple/OldestHold/Answers')
        assert (answers[0], answers[-1]) == ('retry', 'abort_job')
        roles = await reader.value('Simple/OldestHold/AnswerRoles')
        assert (roles[0], roles[-1]) == ('operate or engineer', 'engineer')
        message = await reader.value('Simple/OldestHold/Message')
        assert 'section 4' in message
        assert 'aborted' in message
        await reader.wait('Simple/StopReason', lambda entry: entry == 'own_fault')
        assert await reader.value('Simple/StopMessage')
        await reader.wait('Simple/StandsCause', lambda entry: entry == 'hold')
        assert f'hold {hold}' in await reader.value('Simple/StandsReason')
        assert await reader.value('Simple/StandsSince') is not None
        wrong = await reader.call('Simple/AnswerHold', hold, 'wait', '')
        assert wrong[0] is False
        assert 'expected one that is possible now (retry, ' in wrong[1]
        done = await reader.call('Simple/AnswerHold', hold, 'retry', 'seen by the camera')
        assert done[0] is True
        await reader.wait('Simple/LastJob/Good', lambda entry: entry == 4)
        assert await reader.value('Simple/LastJob/State') == 'Ended'
        assert await reader.value('Simple/CurrentJob/ID') == ''
        assert await reader.value('Simple/Holds') == 0

    reading(scene.url, look)
    (decided,) = (entry for entry in scene.events('operator.decided') if entry.hold)
    assert (decided.answer, decided.reason) == ('retry', 'seen by the camera')
    assert decided.origin.startswith('opcua ')


def test_all_order_mistakes_are_listed_before_sending(scene: Scene) -> None:
    async def look(reader: Reader) -> None:
        answer = await submit(reader, 'a/b', '', count(1), texts('speed', 'lot=1', 'lot=2'))
        assert answer[:2] == [False, 'the order was not sent']
        assert [finding.partition(':')[0] for finding in answer[2]] == [
            'Id', 'Script', 'Parameters', 'Parameters',
        ]  # fmt: skip

    reading(scene.url, look)


def test_what_the_cell_refuses_is_told(scene: Scene) -> None:
    async def look(reader: Reader) -> None:
        accepted, _, findings = await submit(reader, *order('WO-3', 1, 'speed=12'))
        assert accepted is False
        assert 'speed' in findings[0]
        accepted, message = await reader.call('Simple/Command', 'cancel', 'WO-9', 'no such')
        assert accepted is False
        assert 'WO-9' in message

    reading(scene.url, look)
    assert any(row.message and 'WO-9' in row.message for row in scene.events('operator.refused'))


def test_any_request_is_made_by_its_name(scene: Scene) -> None:
    async def look(reader: Reader) -> None:
        async def ask(name: str, arguments: str) -> Any:
            return await reader.call('Simple/Request', name, arguments, 'a test')

        added = '{order: WO-20, script: inspect_and_assemble, quantity: 2}'
        accepted, message, _ = await ask('queue.add', f'{{orders: [{added}], held: true}}')
        assert (accepted, message) == (True, 'WO-20 is queued and held')
        for name, arguments in (
            ('job.update', '{"job": "WO-20", "quantity": 3}'),
            ('job.cancel', 'job: WO-20'),
        ):
            assert (await ask(name, arguments))[0] is True
        for name, arguments, expected in (
            ('job.fly', '', "there is no request 'job.fly'"),
            ('job.move', '{job: WO-20}', 'job.move needs position'),
            ('job.move', 'WO-20', 'expected the arguments as a mapping'),
            ('job.hold', '{job: WO-20}', 'WO-20 is no longer listed'),
        ):
            accepted, message, _ = await ask(name, arguments)
            assert accepted is False
            assert expected in message

    reading(scene.url, look)
    (updated,) = (event for event in scene.events('operator.decided') if event.answer == 'update')
    assert (updated.job, updated.reason) == ('WO-20', 'a test')


def test_cell_and_job_commands_are_recorded(scene: Scene) -> None:
    async def look(reader: Reader) -> None:
        assert (await reader.call('Simple/Command', 'Pause', '', ''))[0] is True
        await reader.wait('Simple/StopReason', lambda entry: entry == 'operator')
        assert (await submit(reader, *order('WO-4')))[0] is True
        await reader.wait('Simple/NextJob/ID', lambda entry: entry == 'WO-4')
        done = await reader.call('Simple/Command', 'cancel', 'WO-4', 'the customer said so')
        assert done[0] is True, done
        await reader.wait('Simple/Queued', lambda entry: entry == 0)
        assert (await reader.call('Simple/Command', 'resume', '', 'lunch is over'))[0] is True
        await reader.wait('Simple/StopReason', lambda entry: entry == '')

    reading(scene.url, look)
    decided = {entry.answer: entry for entry in scene.events('operator.decided')}
    assert decided['pause'].reason == 'no comment (OPC UA Command)'
    assert (decided['cancel'].job, decided['cancel'].reason) == ('WO-4', 'the customer said so')


def test_plant_reasons_are_offered_in_every_language(scene: Scene) -> None:
    async def look(reader: Reader) -> None:
        offered = {
            name: await reader.value(f'Simple/Reasons/{name}') for name in ('Codes', 'de', 'en')
        }
        assert offered['Codes'] == list(REASONS)
        assert offered['de'] == [reason.words['de'] for reason in REASONS.values()]
        assert offered['en'] == [reason.words['en'] for reason in REASONS.values()]
        assert await reader.value('Simple/Reasons/Groups') == [
            reason.group for reason in REASONS.values()
        ]

    reading(scene.url, look)


def test_coded_requests_have_methods_with_code(scene: Scene) -> None:
    async def look(reader: Reader) -> None:
        for name, arguments in (
            ('Command', COMMAND), ('ComponentCommand', COMPONENT_COMMAND),
            ('AnswerHold', ANSWER_HOLD),
        ):  # fmt: skip
            method = reader.node(f'Simple/{name}WithCode')
            declared = await (await method.get_child('0:InputArguments')).read_value()
            assert [item.Name for item in declared] == [*(item.name for item in arguments), 'Code']
        names = [(await item.read_browse_name()).Name for item in await top(reader).get_methods()]
        assert 'ReleaseScriptWithCode' not in names

    reading(scene.url, look)


def test_code_reaches_cell_or_is_rejected(scene: Scene) -> None:
    async def look(reader: Reader) -> None:
        done = await reader.call('Simple/CommandWithCode', 'pause', '', 'lunch', 'LUNCH')
        assert done[0] is True
        assert "this node knows no reasons, and not 'LUNCH'" in done[1]
        accepted, message = await reader.call('Simple/CommandWithCode', 'start', '', '', 'JAM')
        assert (accepted, message) == (
            False,
            'Code: expected none, for start has no reason of the plant',
        )
        done = await reader.call('Simple/CommandWithCode', 'resume', '', 'lunch is over', ' ')
        assert done[0] is True
        accepted, message = await reader.call('Simple/ClassifyStop', ':1', 'JAM', '')
        assert (accepted, 'keeps no journal' in message) == (False, True)

    reading(scene.url, look)
    assert not any(event.code for event in scene.events('operator.decided'))


def top(reader: Reader) -> asyncua.Node:
    return reader.node('Simple')


def test_unknown_command_lists_valid_ones(scene: Scene) -> None:
    async def look(reader: Reader) -> None:
        accepted, message = await reader.call('Simple/Command', 'faster', '', '')
        assert accepted is False
        assert message.startswith('Verb: expected a command to the cell: reset, start, pause')

    reading(scene.url, look)


@pytest.mark.parametrize(
    ('given', 'error'),
    [
        (('WO-5', 'x', count(1)), ua.uaerrors.BadArgumentsMissing),
        (('WO-5', 'x', count(1), texts(), 'more'), ua.uaerrors.BadTooManyArguments),
        (('WO-5', 'x', 1, texts()), ua.uaerrors.BadInvalidArgument),  # an Int64
        (('WO-5', 'x', count(1), 'lot=1'), ua.uaerrors.BadInvalidArgument),  # not a list
    ],
)
def test_arguments_of_another_type_are_refused(
    scene: Scene, given: tuple[Any, ...], error: type[Exception]
) -> None:
    async def look(reader: Reader) -> None:
        with pytest.raises(error):
            await submit(reader, *given)

    reading(scene.url, look)


def test_variables_are_described_typed_and_read_only(scene: Scene) -> None:
    async def look(reader: Reader) -> None:
        expected = {f'Simple/{name}': row for name, row in simple.CELL.items()}
        for place in ('CurrentJob', 'NextJob', 'LastJob'):
            expected |= {f'Simple/{place}/{name}': row for name, row in simple.JOB.items()}
        expected |= {f'Simple/OldestHold/{name}': row for name, row in simple.HOLD.items()}
        for path, row in expected.items():
            node = reader.node(path)
            assert (await node.read_description()).Text == row.meaning
            assert await node.read_data_type() == ua.NodeId(row.type.value)
            value = (await node.read_data_value()).Value
            assert (value.VariantType, value.is_array) == (row.type, row.is_list)
            assert (await node.read_browse_name()).Name == path.rpartition('/')[2]
            assert await node.get_user_access_level() == {ua.AccessLevel.CurrentRead}
        for name, arguments in (
            ('SubmitOrder', SUBMIT_ORDER), ('Command', COMMAND), ('AnswerHold', ANSWER_HOLD),
        ):  # fmt: skip
            method = reader.node(f'Simple/{name}')
            declared = await (await method.get_child('0:InputArguments')).read_value()
            assert [row.Name for row in declared] == [row.name for row in arguments]
            assert [row.Description.Text for row in declared] == [row.meaning for row in arguments]
            assert [row.ValueRank for row in declared] == [
                1 if row.is_list else -1 for row in arguments
            ]

    reading(scene.url, look)


def test_times_are_those_of_the_cells_clock(scene: Scene) -> None:
    async def look(reader: Reader) -> None:
        value = await reader.node('Simple/State').read_data_value()
        since = await reader.value('Simple/StateSince')
        assert value.SourceTimestamp >= since
        assert value.ServerTimestamp is not None

    reading(scene.url, look)


def test_the_server_says_what_it_is(scene: Scene) -> None:
    async def look(reader: Reader) -> None:
        nodes = reader.client.nodes
        assert await nodes.server_state.read_value() == ua.ServerState.Running
        status = await reader.client.get_node(ua.ObjectIds.Server_ServerStatus).read_value()
        assert status.BuildInfo.ProductName == 'bt_orchestrator'
        assert status.StartTime <= status.CurrentTime
        (cell,) = [
            node
            for node in await nodes.objects.get_children()
            if node.nodeid.NamespaceIndex == reader.idx
        ]
        assert (await cell.read_browse_name()).Name == 'reference_cell'

    reading(scene.url, look)


def test_oldest_hold_stays_first_after_clock_step() -> None:
    holds = (hold('1', since=3600.0), hold('2', since=60.0))
    assert dict(simple.values(status(holds=holds)))['OldestHold/ID'] == '1'


def test_good_items_are_the_packed_ones_that_conform() -> None:
    shown = job(packed=6, nonconforming=1, good=5, started=6, started_at=NOW_S)
    values = dict(simple.values(status(jobs=(shown,))))
    names = ('Packed', 'Good', 'Nonconforming')
    assert [values[f'CurrentJob/{name}'] for name in names] == [6, 5, 1]
