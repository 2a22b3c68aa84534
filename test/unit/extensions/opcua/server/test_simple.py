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


def texts(*found: str) -> ua.Variant:
    return ua.Variant(list(found), ua.VariantType.String)


def order(id_: str, quantity: int = 1, *parameters: str) -> tuple[Any, ...]:
    return id_, 'inspect_and_assemble', count(quantity), texts(*parameters)


def test_a_held_job_is_seen_answered_and_ends(scene: Scene) -> None:
    """The first job meets the fault."""

    async def look(reader: Reader) -> None:
        assert await reader.value('Simple/Connected') is True
        assert await reader.value('Simple/CurrentJob/ID') == ''
        assert (await submit(reader, *order('WO-1', 4)))[0] is True
        await reader.wait('Simple/CurrentJob/ID', lambda one: one == 'WO-1')
        assert await reader.value('Simple/CurrentJob/Planned') == 4
        hold = await reader.wait('Simple/OldestHold/ID', bool)
        assert await reader.value('Simple/OldestHold/Job') == 'WO-1'
        answers = await reader.value('Simple/OldestHold/Answers')
        assert (answers[0], answers[-1]) == ('retry', 'abort_job')
        roles = await reader.value('Simple/OldestHold/AnswerRoles')
        assert (roles[0], roles[-1]) == ('operate or engineer', 'engineer')
        said = await reader.value('Simple/OldestHold/Message')
        assert 'section 4' in said
        assert 'aborted' in said
        await reader.wait('Simple/StopReason', lambda one: one == 'own_fault')
        assert await reader.value('Simple/StopMessage')
        await reader.wait('Simple/StandsCause', lambda one: one == 'hold')
        assert f'hold {hold}' in await reader.value('Simple/StandsReason')
        assert await reader.value('Simple/StandsSince') is not None
        wrong = await reader.call('Simple/AnswerHold', hold, 'wait', '')
        assert wrong[0] is False
        assert 'expected one that is possible now (retry, ' in wrong[1]
        done = await reader.call('Simple/AnswerHold', hold, 'retry', 'seen by the camera')
        assert done[0] is True
        await reader.wait('Simple/LastJob/Good', lambda one: one == 4)
        assert await reader.value('Simple/LastJob/State') == 'Ended'
        assert await reader.value('Simple/CurrentJob/ID') == ''
        assert await reader.value('Simple/Holds') == 0

    reading(scene.url, look)
    (decided,) = (one for one in scene.events('operator.decided') if one.hold)
    assert (decided.answer, decided.reason) == ('retry', 'seen by the camera')
    assert decided.origin.startswith('opcua ')


def test_every_mistake_of_an_order_is_told_and_nothing_is_sent(scene: Scene) -> None:
    async def look(reader: Reader) -> None:
        found = await submit(reader, 'a/b', '', count(1), texts('speed', 'lot=1', 'lot=2'))
        assert found[:2] == [False, 'the order was not sent']
        assert [one.partition(':')[0] for one in found[2]] == [
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
    assert any(one.message and 'WO-9' in one.message for one in scene.events('operator.refused'))


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
        for name, arguments, told in (
            ('job.fly', '', "there is no request 'job.fly'"),
            ('job.move', '{job: WO-20}', 'job.move needs position'),
            ('job.move', 'WO-20', 'expected the arguments as a mapping'),
            ('job.hold', '{job: WO-20}', 'WO-20 is no longer listed'),
        ):
            accepted, message, _ = await ask(name, arguments)
            assert accepted is False
            assert told in message

    reading(scene.url, look)
    (updated,) = (one for one in scene.events('operator.decided') if one.answer == 'update')
    assert (updated.job, updated.reason) == ('WO-20', 'a test')


def test_commands_to_the_cell_and_to_jobs_are_on_record(scene: Scene) -> None:
    async def look(reader: Reader) -> None:
        assert (await reader.call('Simple/Command', 'Pause', '', ''))[0] is True
        await reader.wait('Simple/StopReason', lambda one: one == 'operator')
        assert (await submit(reader, *order('WO-4')))[0] is True
        await reader.wait('Simple/NextJob/ID', lambda one: one == 'WO-4')
        done = await reader.call('Simple/Command', 'cancel', 'WO-4', 'the customer said so')
        assert done[0] is True, done
        await reader.wait('Simple/Queued', lambda one: one == 0)
        assert (await reader.call('Simple/Command', 'resume', '', 'lunch is over'))[0] is True
        await reader.wait('Simple/StopReason', lambda one: one == '')

    reading(scene.url, look)
    decided = {one.answer: one for one in scene.events('operator.decided')}
    assert decided['pause'].reason == 'no comment (OPC UA Command)'
    assert (decided['cancel'].job, decided['cancel'].reason) == ('WO-4', 'the customer said so')


def test_reasons_of_the_plant_are_offered_in_each_language_of_their_file(scene: Scene) -> None:
    async def look(reader: Reader) -> None:
        told = {
            name: await reader.value(f'Simple/Reasons/{name}') for name in ('Codes', 'de', 'en')
        }
        assert told['Codes'] == list(REASONS)
        assert told['de'] == [one.words['de'] for one in REASONS.values()]
        assert told['en'] == [one.words['en'] for one in REASONS.values()]
        assert await reader.value('Simple/Reasons/Groups') == [
            one.group for one in REASONS.values()
        ]

    reading(scene.url, look)


def test_a_method_with_a_code_for_each_that_has_requests_with_one(scene: Scene) -> None:
    async def look(reader: Reader) -> None:
        for name, arguments in (
            ('Command', COMMAND), ('ComponentCommand', COMPONENT_COMMAND),
            ('AnswerHold', ANSWER_HOLD),
        ):  # fmt: skip
            method = reader.node(f'Simple/{name}WithCode')
            declared = await (await method.get_child('0:InputArguments')).read_value()
            assert [one.Name for one in declared] == [*(one.name for one in arguments), 'Code']
        names = [(await one.read_browse_name()).Name for one in await top(reader).get_methods()]
        assert 'ReleaseScriptWithCode' not in names

    reading(scene.url, look)


def test_a_code_goes_to_the_cell_and_one_that_nothing_takes_does_not(scene: Scene) -> None:
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
    assert not any(one.code for one in scene.events('operator.decided'))


def top(reader: Reader) -> asyncua.Node:
    return reader.node('Simple')


def test_a_word_that_is_no_command_is_told_with_those_there_are(scene: Scene) -> None:
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


def test_everything_is_described_typed_and_only_to_be_read(scene: Scene) -> None:
    async def look(reader: Reader) -> None:
        expected = {f'Simple/{name}': one for name, one in simple.CELL.items()}
        for place in ('CurrentJob', 'NextJob', 'LastJob'):
            expected |= {f'Simple/{place}/{name}': one for name, one in simple.JOB.items()}
        expected |= {f'Simple/OldestHold/{name}': one for name, one in simple.HOLD.items()}
        for path, one in expected.items():
            node = reader.node(path)
            assert (await node.read_description()).Text == one.meaning
            assert await node.read_data_type() == ua.NodeId(one.type.value)
            found = (await node.read_data_value()).Value
            assert (found.VariantType, found.is_array) == (one.type, one.is_list)
            assert (await node.read_browse_name()).Name == path.rpartition('/')[2]
            assert await node.get_user_access_level() == {ua.AccessLevel.CurrentRead}
        for name, arguments in (
            ('SubmitOrder', SUBMIT_ORDER), ('Command', COMMAND), ('AnswerHold', ANSWER_HOLD),
        ):  # fmt: skip
            method = reader.node(f'Simple/{name}')
            declared = await (await method.get_child('0:InputArguments')).read_value()
            assert [one.Name for one in declared] == [one.name for one in arguments]
            assert [one.Description.Text for one in declared] == [one.meaning for one in arguments]
            assert [one.ValueRank for one in declared] == [
                1 if one.is_list else -1 for one in arguments
            ]

    reading(scene.url, look)


def test_times_are_those_of_the_cells_clock(scene: Scene) -> None:
    async def look(reader: Reader) -> None:
        found = await reader.node('Simple/State').read_data_value()
        since = await reader.value('Simple/StateSince')
        assert found.SourceTimestamp >= since
        assert found.ServerTimestamp is not None

    reading(scene.url, look)


def test_the_server_says_what_it_is(scene: Scene) -> None:
    async def look(reader: Reader) -> None:
        nodes = reader.client.nodes
        assert await nodes.server_state.read_value() == ua.ServerState.Running
        status = await reader.client.get_node(ua.ObjectIds.Server_ServerStatus).read_value()
        assert status.BuildInfo.ProductName == 'bt_orchestrator'
        assert status.StartTime <= status.CurrentTime
        (cell,) = [
            one
            for one in await nodes.objects.get_children()
            if one.nodeid.NamespaceIndex == reader.idx
        ]
        assert (await cell.read_browse_name()).Name == 'reference_cell'

    reading(scene.url, look)


def test_the_oldest_hold_is_the_first_raised_also_after_a_set_clock() -> None:
    holds = (hold('1', since=3600.0), hold('2', since=60.0))
    assert dict(simple.values(status(holds=holds)))['OldestHold/ID'] == '1'


def test_good_items_are_the_packed_ones_that_conform() -> None:
    shown = job(packed=6, nonconforming=1, good=5, started=6, started_at=NOW_S)
    told = dict(simple.values(status(jobs=(shown,))))
    names = ('Packed', 'Good', 'Nonconforming')
    assert [told[f'CurrentJob/{name}'] for name in names] == [6, 5, 1]
