"""The values of PackML's Admin and Status, and the states of its machines."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from datetime import datetime, timezone

from asyncua import ua

from bt_orchestrator.extensions.opcua.mes.packml import (
    COMMANDS,
    MODE_NAMES,
    MODE_NUMBERS,
    NUMBERS,
    PRODUCE,
    STATE_NUMBERS,
    Counter,
    Machine,
    MachineTransition,
    Speedometer,
    Stop,
    packml_values,
    states_in,
    transitions_between,
)
from bt_orchestrator.extensions.opcua.server.space import Space
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.judging.belt_statement import EMPTY
from bt_orchestrator.model.packml import TRANSITIONS, PackmlState, UnitMode
from bt_orchestrator.model.status import CellStatus, SectionStatus

TOP = 'PackML'
VERSION = 'TR88.00.02-2015'
STATES = max(STATE_NUMBERS.values()) + 1
MODES = max(MODE_NUMBERS.values()) + 1
"""Sizes of the arrays of times: numbers of states and of unit modes count from 1."""

WITHOUT = ('Status/MachSpeed', 'Status/MachSpeed/EURange', 'Status/CurMachSpeed/EURange')
"""Mandatory variables that the cell has no value for: its speed cannot be set."""

OWN: Mapping[str, ua.VariantType] = {
    'Status/StateCurrent': ua.VariantType.Int32,
    'LastRefusal': ua.VariantType.String,
    'Belt': ua.VariantType.String,
}
"""Variables that the nodeset has no place for."""

ITEM = ua.EUInformation(
    'http://www.opcfoundation.org/UA/units/un/cefact', 4_404_274, ua.LocalizedText('item'),
    ua.LocalizedText('piece'),
)  # fmt: skip
"""UNECE code C62."""

NEVER = datetime(1601, 1, 1, tzinfo=timezone.utc)
"""No time, in a structure."""

_CODES = ua.StatusCodes


class Shown:
    """Writes values."""

    def __init__(self, space: Space, names: Mapping[Machine, Mapping[str, ua.NodeId]]) -> None:
        """Prepare.

        :param names: states and transitions of the types, by name
        """
        self._space = space
        self._values = space.values
        self._names = names
        # The nodeset's structures: asyncua makes a class of each as it loads them.
        self._count, self._alarm = ua.PackMLCountDataType, ua.PackMLAlarmDataType
        self.begin()

    def begin(self) -> None:
        """Count anew."""
        self._counter = Counter()
        self._speed = Speedometer()

    async def build(self) -> None:
        """Write what never changes, and make what the nodeset has no place for."""
        space, kind = self._space, ua.VariantType
        for name, type_ in OWN.items():
            await space.variable(f'{TOP}/{name}', type_, VALUE_MEANINGS[name])
        await self._write('LastRefusal', ua.Variant('', kind.String))
        await self._write('PackMLVersion', ua.Variant(VERSION, kind.String))
        await self._write('Status/UnitSupportedModes', _node(await self._modes()))
        for path in WITHOUT:
            await self._code(path, _CODES.BadNotSupported)
        for machine, names in self._names.items():
            states, transitions = _ours(machine)
            for name, these in (('States', states), ('Transitions', transitions)):
                ids = [names[member] for member in sorted(these)]
                value = ua.Variant(ids, kind.NodeId, is_array=True)
                await self._write(f'{machine.value}/Available{name}', value)
            for name in ('', '/Id', '/TransitionTime'):
                path = f'{machine.value}/LastTransition{name}'
                await self._code(path, _CODES.BadWaitingForInitialData)

    async def _modes(self) -> ua.NodeId:
        """Make the enumeration of the unit modes that the cell has."""
        modes = [
            ua.EnumValueType(number, ua.LocalizedText(name)) for number, name in MODE_NAMES.items()
        ]
        base = self._space.server.get_node(ua.ObjectIds.Enumeration)
        path = 'CellUnitMode'
        made = await base.add_data_type(
            self._space.id(path), ua.QualifiedName(path, self._space.idx)
        )
        await self._space.described(made, 'the unit modes that the cell has')
        value = _structures(modes, is_list=True)
        values = await made.add_property(
            self._space.id(f'{path}/EnumValues'), ua.QualifiedName('EnumValues', 0), value
        )
        await self._space.described(values, 'number and name of each unit mode')
        return made.nodeid

    async def _write(self, path: str, value: ua.Variant) -> None:
        await self._space.node(f'{TOP}/{path}').write_value(value)

    async def _code(self, path: str, code: int) -> None:
        """Say that there is no value, and why."""
        node = self._space.node(f'{TOP}/{path}')
        await node.write_value(ua.DataValue(StatusCode=ua.StatusCode(code)))

    # --- a status ---------------------------------------------------------------------------

    def hear(self, event: Event) -> None:
        """Take note of the moves of the belt."""
        self._speed.hear(event)

    def show(self, status: CellStatus) -> None:
        """Show a status."""
        self._counter.show(status)
        values, at = packml_values(status), status.stamp
        since, mode = status.state_since, MODE_NUMBERS[status.unit_mode]
        self._put('Status/UnitModeCurrent', ua.Variant(mode, ua.VariantType.Int32), at)
        self._put('Status/StateCurrent', values.state, since)
        self._put('Status/StateChangeInProcess', values.is_changing, since)
        self._put('Status/EquipmentStarved', values.is_starved, at)
        self._put('Status/EquipmentBlocked', values.is_blocked, at)
        self._put_speed(status)
        self._put('Admin/StateCurrentTime', _times(values.in_state_s, mode), at)
        self._put('Admin/StateCumulativeTime', _times(values.total_s), at)
        self._put('Admin/StopReason', self._stop(values.stop), at)
        self._put_counts(at)
        self._put_states(status)
        self._put_belt(status)

    def put_refusal(self, message: str, at: float) -> None:
        """Show why the last command was refused."""
        self._put('LastRefusal', message, at)

    def put_transition(self, transition: MachineTransition, at: float) -> None:
        """Show the last transition of a machine."""
        path = f'{transition.machine.value}/LastTransition'
        self._put(path, _text(transition.name), at)
        self._put(f'{path}/Id', _node(self._names[transition.machine][transition.name]), at)
        self._put(f'{path}/TransitionTime', _time(at), at)

    def _put(self, path: str, value: object, at: float, code: int = _CODES.Good) -> None:
        self._values.put(self._space.node(f'{TOP}/{path}'), value, at, code=code)

    def _put_speed(self, status: CellStatus) -> None:
        """Show moves of the belt a minute: each brings every item one section further."""
        speed = self._speed.a_minute(status.state, status.stamp)
        code = _CODES.UncertainInitialValue if speed is None else _CODES.Good
        value = ua.Variant(round(speed or 0.0, 2), ua.VariantType.Float)
        self._put('Status/CurMachSpeed', value, status.stamp, code)

    def _put_counts(self, at: float) -> None:
        """Show the counters; each element has the total of the line beside its own count."""
        counter = self._counter
        for name, of_job, total in (
            ('ProdProcessedCount', 'processed', counter.processed),
            ('ProdDefectiveCount', 'defective', counter.defective),
        ):
            counts = [
                self._count(
                    ID=number,
                    Name=count.job,
                    Unit=ITEM,
                    Count=getattr(count, of_job),
                    AccCount=total,
                )
                for number, count in enumerate(counter.counts, 1)
            ]
            self._put(f'Admin/{name}', _structures(counts, is_list=True), at)

    def _stop(self, stop: Stop) -> ua.Variant:
        since = NEVER if stop.since is None else datetime.fromtimestamp(stop.since, timezone.utc)
        reason = self._alarm(
            ID=stop.reason.number,
            Value=stop.hold,
            Message=stop.message,
            Category=stop.reason.category,
            DateTime=since,
            AckDateTime=NEVER,
            Trigger=stop.since is not None,
        )
        return _structures(reason)

    def _put_states(self, status: CellStatus) -> None:
        active, at = states_in(status.state), status.state_since
        for machine in Machine:
            path = f'{machine.value}/CurrentState'
            name = active.get(machine)
            if name is None:
                for variable in (path, f'{path}/Id', f'{path}/Number'):
                    self._put(variable, ua.Variant(), at, _CODES.BadStateNotActive)
                continue
            self._put(path, _text(name), at)
            self._put(f'{path}/Id', _node(self._names[machine][name]), at)
            number = ua.Variant(NUMBERS[name], ua.VariantType.UInt32)
            self._put(f'{path}/Number', number, at)

    def _put_belt(self, status: CellStatus) -> None:
        """Show the belt and its event in one value: they belong together."""
        slots = ', '.join(f'{section.number}={_standing(section)}' for section in status.sections)
        is_asked = status.state is PackmlState.ABORTED or status.unit_mode is UnitMode.MANUAL
        shown = f'{status.seq}: {slots}' if is_asked else ''
        self._put('Belt', shown, status.stamp)


def _standing(section: SectionStatus) -> str:
    slot = section.slot
    return slot.id if slot is not None and slot.present else EMPTY


def _ours(machine: Machine) -> tuple[set[str], set[str]]:
    """Return the states and transitions of a machine that the cell can have."""
    states = {states_in(state)[machine] for state in PackmlState if machine in states_in(state)}
    transitions = {
        transition.name
        for before, row in TRANSITIONS.items()
        for after in row.values()
        for transition in transitions_between(before, after)
        if transition.machine is machine
    }
    return states, transitions


def _times(by_state: Mapping[int, int], mode: int = PRODUCE) -> ua.Variant:
    """Return seconds by unit mode and state; all of them are of one mode."""
    rows = [[0] * STATES for _ in range(MODES)]
    rows[mode] = [by_state.get(number, 0) for number in range(STATES)]
    return ua.Variant(rows, ua.VariantType.Int32)


def _structures(value: object, *, is_list: bool = False) -> ua.Variant:
    return ua.Variant(value, ua.VariantType.ExtensionObject, is_array=is_list)


def _text(words: str) -> ua.Variant:
    return ua.Variant(ua.LocalizedText(words), ua.VariantType.LocalizedText)


def _node(id_: ua.NodeId) -> ua.Variant:
    return ua.Variant(id_, ua.VariantType.NodeId)


def _time(seconds: float) -> ua.Variant:
    return ua.Variant(datetime.fromtimestamp(seconds, timezone.utc), ua.VariantType.DateTime)


# The descriptions of PackML nodes; the page about the server has the same table.

VALUE_MEANINGS: Mapping[str, str] = {
    'Status/StateCurrent': 'number of the state, as in the tag Status.StateCurrent',
    'Status/StateChangeInProcess': 'it is an acting state, which ends by itself',
    'Status/EquipmentStarved': 'the line waits for its source, and goes on by itself',
    'Status/EquipmentBlocked': 'the line waits for its sink, and goes on by itself',
    'Status/CurMachSpeed': (
        'moves of the belt a minute, over the last ten; each brings every item one section '
        'further. 0 outside of Execute, UncertainInitialValue until two moves were seen; it '
        'falls while a move is overdue'
    ),
    'Status/MachSpeed': 'BadNotSupported, as its range: the speed of the line cannot be set',
    'Status/UnitModeCurrent': '1, Produce; or 3, Manual: the cell stands, and runs single goals',
    'Admin/StateCurrentTime': 'seconds of the present stay, by unit mode and state',
    'Admin/StateCumulativeTime': (
        'seconds since the journal began, by unit mode and state; those of all modes stand under 1'
    ),
    'Admin/ProdProcessedCount': (
        'items produced, good or bad: packed, rejected or taken off by hand. An element for each '
        'job on the line, the oldest first, else for the last job. Name: its id; Count: its own; '
        'AccCount: of all jobs'
    ),
    'Admin/ProdDefectiveCount': (
        'the same of items that are not good: rejected, nonconforming, or taken off by hand'
    ),
    'Admin/StopReason': (
        'why the line stands still: ID and Category are numbers that never change, Value is the '
        'number of the hold that decides it, DateTime since when; Trigger is false while it runs'
    ),
    'LastRefusal': 'why the last command was refused',
    'Belt': (
        'what stands on the belt of a cell that is aborted or in manual mode, for ClearAsShown '
        'and ProduceAsShown; else empty'
    ),
}
"""Variables, by their path below PackML."""

_OBJECTS: Mapping[str, str] = {
    '': 'the cell in the words of PackML (OPC 30050)',
    '/Admin': 'times, counters, and why the line stands still',
    '/Status': 'state, speed, and whether source and sink are ready',
    '/Status/UnitSupportedModes': 'the unit modes that the cell has',
    '/PackMLVersion': 'edition of PackML that the states follow',
    f'/{Machine.BASE.value}': 'Cleared, Aborting or Aborted; the machine inside is for Cleared',
    f'/{Machine.MACHINE.value}': (
        'Running, Stopping, Stopped or Clearing; the machine inside is for Running'
    ),
    f'/{Machine.EXECUTE.value}': 'the states of a line that was started',
}
_NOT_OURS: Mapping[str, str] = {
    '/SetUnitMode': (
        '3, Manual, asks for manual mode; 1, Produce, changes nothing, and ProduceAsShown ends '
        'manual mode; else BadNotSupported'
    ),
    '/SetMachSpeed': 'BadNotSupported: the speed of the line cannot be set',
    '/SetProduct': 'BadNotSupported: an order says what is made',
    '/SetParameter': 'BadNotSupported: an order has the parameters',
}

METHOD_MEANINGS: Mapping[Machine, tuple[str, ...]] = {
    Machine.BASE: ('Abort',),
    Machine.MACHINE: ('Reset', 'Stop'),
    Machine.EXECUTE: ('Reset', 'Start', 'Hold', 'Unhold'),
}
"""Where the nodeset has the commands."""


def meanings(top: str) -> Iterator[tuple[str, str]]:
    """Yield the path and the meaning of each node that is not made with one.

    :param top: path of PackML
    """
    yield from ((f'{top}/{path}', meaning) for path, meaning in VALUE_MEANINGS.items())
    for below, meaning in {**_OBJECTS, **_NOT_OURS}.items():
        yield f'{top}{below}', meaning
    for machine, names in METHOD_MEANINGS.items():
        for name in names:
            yield f'{top}/{machine.value}/{name}', COMMANDS[name].effect
