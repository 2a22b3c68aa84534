"""PackML, as asyncua's own client sees it: a server before a cell in virtual time."""

from __future__ import annotations

import json
import time
from collections.abc import Iterator
from typing import Any, NamedTuple

import pytest
from asyncua import ua
from opcua_events import Heard
from opcua_reader import Reader, reading
from opcua_stand import opcua_stand
from patience import PATIENCE_S
from web.stand_cell import StandCell

from bt_orchestrator.extensions.opcua.server.packml_values import meanings
from bt_orchestrator.model.events import OperatorDecided
from bt_orchestrator.model.jobs.order import WorkOrder

BASE = 'PackML/BaseStateMachine'
MACHINE = f'{BASE}/MachineState'
EXECUTE = f'{MACHINE}/ExecuteState'

NO_PARAMETERS = ua.Variant([], ua.VariantType.ExtensionObject, is_array=True)


class Scene(NamedTuple):
    cell: StandCell
    url: str


@pytest.fixture(scope='module')
def scene(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Scene]:
    """One cell for all; each test leaves it without a job and without a stop."""
    with opcua_stand(tmp_path_factory.mktemp('stand')) as (cell, server):
        reading(server.address, begin)
        yield Scene(cell, server.address)


async def begin(reader: Reader) -> None:
    """Leave a new cell, where nothing was refused yet, as each test does."""
    assert await reader.value('PackML/LastRefusal') == ''
    await reader.call(f'{MACHINE}/Reset')
    await reader.wait('PackML/Status/StateCurrent', state(4))


def order(scene: Scene, name: str, quantity: int) -> None:
    assert scene.cell.queue(WorkOrder(scene.cell.script, name, quantity)).accepted


async def states(reader: Reader) -> list[str]:
    """Return the state of each machine; those that are not active say so."""
    names = []
    for path in (BASE, MACHINE, EXECUTE):
        node = reader.node(f'{path}/CurrentState')
        value = await node.read_data_value(raise_on_bad_status=False)
        is_good = value.StatusCode.is_good()
        names.append(value.Value.Value.Text if is_good else value.StatusCode.name)
    return names


async def code(reader: Reader, path: str) -> str:
    value = await reader.node(path).read_data_value(raise_on_bad_status=False)
    return str(value.StatusCode.name)


async def refused(reader: Reader, path: str, *given: Any) -> str:
    with pytest.raises(ua.UaStatusCodeError) as error:
        await reader.call(path, *given)
    return type(error.value).__name__


def state(number: int) -> Any:
    return lambda value: value == number


def test_a_job_in_the_words_of_packml(scene: Scene) -> None:
    async def look(reader: Reader) -> None:
        heard = await Heard.of(reader)
        made = await made_so_far(reader)
        order(scene, 'WO-1', 4)
        await reader.wait('PackML/Status/StateCurrent', state(6))
        assert await code(reader, 'PackML/Status/CurMachSpeed') == 'UncertainInitialValue'
        heard_speed = await Heard.of_value(reader, 'PackML/Status/CurMachSpeed')
        assert await states(reader) == ['Cleared', 'Running', 'Execute']
        id_ = await reader.value(f'{EXECUTE}/CurrentState/Id')
        named = await reader.client.get_node(id_).read_browse_name()
        assert named.Name == 'Execute'
        assert await reader.value(f'{EXECUTE}/CurrentState/Number') == 6
        await reader.wait('PackML/Status/StateCurrent', state(17))
        assert await reader.value('PackML/Status/CurMachSpeed') == 0.0
        assert any(speed > 0 for speed in heard_speed.values)
        (count,) = await reader.value('PackML/Admin/ProdProcessedCount')
        assert (count.ID, count.Name, count.Count, count.AccCount) == (1, 'WO-1', 4, made + 4)
        (bad,) = await reader.value('PackML/Admin/ProdDefectiveCount')
        assert (bad.Count, bad.AccCount) == (0, 0)
        stop = await reader.value('PackML/Admin/StopReason')
        assert (stop.ID, stop.Trigger) == (0, False)
        times = await reader.value('PackML/Admin/StateCumulativeTime')
        assert [len(row) for row in times] == [18] * 4
        assert times[1][6] > 0
        transition = await heard.wait(lambda event: event.Message.Text.startswith('Completing to'))
        assert transition.EventType == ua.NodeId(ua.ObjectIds.TransitionEventType)
        assert transition.Transition.Text == 'CompletingToComplete'
        assert getattr(transition, 'ToState/Id') == await reader.value(
            f'{EXECUTE}/CurrentState/Id'
        )
        last = await reader.wait(f'{EXECUTE}/LastTransition', lambda value: 'Comple' in value.Text)
        assert last.Text == 'CompletingToComplete'

    reading(scene.url, look)


async def made_so_far(reader: Reader) -> int:
    """Return how many items all jobs have made."""
    counts = await reader.value('PackML/Admin/ProdProcessedCount')
    return sum(count.AccCount for count in counts[:1])


def test_commands_reach_the_node_with_who_and_why(scene: Scene) -> None:
    async def look(reader: Reader) -> None:
        order(scene, 'WO-2', 4)
        await reader.wait('PackML/Status/StateCurrent', state(6))
        await reader.call(f'{EXECUTE}/Hold')
        stop = await reader.wait('PackML/Admin/StopReason', lambda reason: reason.ID == 101)
        assert (stop.Category, stop.Trigger) == (1, True)
        assert stop.Message.startswith('hold ')
        await reader.wait('PackML/Status/StateCurrent', state(11))
        assert await refused(reader, f'{EXECUTE}/Hold') == 'BadInvalidState'
        assert 'is Held already' in await reader.value('PackML/LastRefusal')
        accepted, _ = await reader.call('Simple/Command', 'pause', '', 'one more')
        assert accepted, 'pauses of the cell stack (7.3)'
        await reader.call(f'{EXECUTE}/Unhold')
        await reader.wait('PackML/Status/StateCurrent', state(17))

    reading(scene.url, look)
    with scene.cell.lock:
        answers = [
            event.answer for event in scene.cell.store.read() if isinstance(event, OperatorDecided)
        ]
    assert answers[-3:] == ['pause', 'pause', 'resume']


def test_refused_command_explains_in_event_and_variable(scene: Scene) -> None:
    async def look(reader: Reader) -> None:
        heard = await Heard.of(reader, 'PackML')
        order(scene, 'WO-0', 1)
        await reader.wait('Simple/LastJob/ID', lambda job_id: job_id == 'WO-0')
        await reader.wait('PackML/Status/StateCurrent', state(17))
        assert await refused(reader, f'{EXECUTE}/Start', NO_PARAMETERS) == 'BadInvalidState'
        refusal = await reader.value('PackML/LastRefusal')
        why = await heard.wait(lambda event: 'start refused' in event.Message.Text)
        assert 'start is for Idle' in why.Message.Text
        assert refusal
        assert refusal in why.Message.Text

    reading(scene.url, look)


def test_aborted_cell_is_cleared_with_shown_belt(scene: Scene) -> None:
    async def look(reader: Reader) -> None:
        assert await reader.value('PackML/Belt') == ''
        await reader.call(f'{BASE}/Abort')
        belt = await reader.wait('PackML/Belt', bool)
        assert belt.endswith(': 1=empty, 2=empty, 3=empty, 4=empty, 5=empty')
        assert await states(reader) == ['Aborted', 'BadStateNotActive', 'BadStateNotActive']
        clear = 'PackML/ClearAsShown'
        assert await refused(reader, clear, 'all well', 'looked') == 'BadInvalidArgument'
        await reader.call(clear, belt, 'looked at it')
        await reader.wait('PackML/Status/StateCurrent', state(2))
        assert await states(reader) == ['Cleared', 'Stopped', 'BadStateNotActive']
        await reader.call(f'{MACHINE}/Reset')
        await reader.wait('PackML/Status/StateCurrent', state(4))
        some = ua.Variant([ua.PackMLDescriptorDataType()], ua.VariantType.ExtensionObject)
        assert await refused(reader, f'{EXECUTE}/Start', some) == 'BadNotSupported'
        await reader.call(f'{EXECUTE}/Start', NO_PARAMETERS)

    reading(scene.url, look)


def test_client_may_call_method_of_type(scene: Scene) -> None:
    async def look(reader: Reader) -> None:
        namespaces = await reader.client.get_namespace_array()
        packml = namespaces.index('http://opcfoundation.org/UA/PackML/')
        order(scene, 'WO-3', 4)
        await reader.wait('PackML/Status/StateCurrent', state(6))
        with pytest.raises(ua.UaStatusCodeError, match='BadInvalidState'):
            await reader.node(MACHINE).call_method(ua.NodeId(376, packml))  # Reset
        await reader.wait('PackML/Status/StateCurrent', state(17))

    reading(scene.url, look)


def test_what_the_cell_does_not_have_says_so(scene: Scene) -> None:
    async def look(reader: Reader) -> None:
        for path in ('MachSpeed', 'MachSpeed/EURange', 'CurMachSpeed/EURange'):
            assert await code(reader, f'PackML/Status/{path}') == 'BadNotSupported'
        speed = ua.Variant(30.0, ua.VariantType.Float)
        assert await refused(reader, 'PackML/SetMachSpeed', speed) == 'BadNotSupported'
        assert await reader.value('PackML/Status/UnitModeCurrent') == 1
        assert await refused(reader, 'PackML/SetUnitMode', _mode(2)) == 'BadNotSupported'
        await reader.call('PackML/SetUnitMode', _mode(1))
        for path in (f'{EXECUTE}/ToComplete', f'{EXECUTE}/Suspend', f'{BASE}/Clear'):
            assert await code(reader, path) == 'BadNodeIdUnknown'

    reading(scene.url, look)


def test_7_11_unit_mode_needs_panel_and_shown_belt(scene: Scene) -> None:
    at_panel = scene.url.replace('stand:', 'panel_stand:')

    async def request(reader: Reader, name: str, **given: object) -> str:
        accepted, message, findings = await reader.call(
            'Simple/Request', name, json.dumps(given), 'to look'
        )
        assert accepted, [message, *findings]
        return str(message)

    async def look(reader: Reader) -> None:
        await reader.call(f'{MACHINE}/Stop')
        await reader.wait('PackML/Status/StateCurrent', state(2))
        assert await refused(reader, 'PackML/SetUnitMode', _mode(3)) == 'BadInvalidState'
        assert 'and the line is in remote' in await reader.value('PackML/LastRefusal')
        await request(reader, 'cell.local')
        await reader.call('PackML/SetUnitMode', _mode(3))
        await reader.wait('PackML/Status/UnitModeCurrent', lambda mode: mode == 3)
        assert await reader.value('Simple/UnitMode') == 'manual'
        goal = {'component': 'component_3a', 'task': 'TASK_A'}
        assert (
            await request(reader, 'component.run_task', **goal) == 'TASK_A is sent to component_3a'
        )
        deadline = time.monotonic() + PATIENCE_S
        while await reader.value('Simple/Manual/State') != 'done':
            await request(reader, 'cell.at_panel')
            assert time.monotonic() < deadline
        assert await reader.value('Simple/Manual/Task') == 'TASK_A'
        assert json.loads(await reader.value('Simple/Manual/Results'))['item_present'] is True
        assert await refused(reader, 'PackML/SetUnitMode', _mode(1)) == 'BadInvalidState'
        assert 'ProduceAsShown ends manual mode' in await reader.value('PackML/LastRefusal')
        belt = await reader.wait('PackML/Belt', bool)
        await reader.call('PackML/ProduceAsShown', belt, 'looked at it')
        await reader.wait('PackML/Status/UnitModeCurrent', lambda mode: mode == 1)
        await request(reader, 'cell.remote')
        await reader.call(f'{MACHINE}/Reset')
        await reader.wait('PackML/Status/StateCurrent', state(4))
        await reader.call(f'{EXECUTE}/Start', NO_PARAMETERS)

    scene.cell.node.running.handler.why_no_panel = lambda: ''
    reading(at_panel, look)


def test_the_nodes_say_what_they_are(scene: Scene) -> None:
    async def look(reader: Reader) -> None:
        for path, meaning in meanings('PackML'):
            assert (await reader.node(path).read_description()).Text == meaning

    reading(scene.url, look)


def _mode(number: int) -> ua.Variant:
    return ua.Variant(number, ua.VariantType.Int32)
