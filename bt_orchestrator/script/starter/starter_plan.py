"""The parts of a starter cell: a belt, a device for every section, and their first tasks.

Devices that were found on a ROS graph come before examples. Which section one belongs to and what
its tasks are good for can only be guessed from names; the files say so, and a user corrects it.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from bt_orchestrator.base.errors import UnknownActionType
from bt_orchestrator.model.action_type import ActionType
from bt_orchestrator.model.cell import CONVEYOR
from bt_orchestrator.model.script import INDEX
from bt_orchestrator.ports import ActionTypes

_PACKAGE = 'bt_orchestrator_interfaces/action'
_INDEX_WORDS = ('INDEX', 'MOVE', 'ADVANCE', 'STEP')
_PREPARING = {'PREPARE', 'HOME', 'INIT', 'INITIALIZE', 'RESET', 'READY'}
_PLACING = {'PLACE', 'LOAD', 'FEED', 'PUT'}
_TAKING = {'PACK', 'UNLOAD', 'REMOVE', 'TAKE'}
_BELT_WORDS = {'CONVEYOR', 'BELT'}
_GENERIC = {'action', 'task', 'execute', 'run', 'command', 'server'}


@dataclass(frozen=True)
class FoundServer:
    """An action server on a ROS graph."""

    action: str
    type: str
    node: str
    """Full name of the node that serves it."""
    state_topics: Sequence[str] = ()
    """Topics of std_msgs/msg/String beside it that may say whether it is ready."""


@dataclass(frozen=True)
class Device:
    """A component to be, or the conveyor."""

    name: str
    action: str
    type: ActionType
    found: FoundServer | None = None
    """None: an example."""
    section: int | None = None

    @property
    def works(self) -> Sequence[str | None]:
        """Task constants that stand for work; one None for a type that does one thing only."""
        if not self.type.has_task_field:
            return [None]
        working = [name for name in self.type.constants if not _parts(name) & _PREPARING]
        return working or [*self.type.constants]

    @property
    def preparations(self) -> Sequence[str]:
        """Task constants that stand for getting ready."""
        return [name for name in self.type.constants if name not in self.works]

    def first(self, words: Collection[str]) -> str | None:
        """Return the first constant for work with one of these words in it."""
        return next((name for name in self.works if name and _parts(name) & {*words}), None)


@dataclass(frozen=True)
class Plan:
    """A starter cell."""

    sections: int
    conveyor: Device
    index_task: str | None
    source: Device
    stations: Sequence[Device]
    sink: Device
    unusable: Sequence[FoundServer] = ()
    """Found, but of a type that is not installed here or that names no task."""

    @property
    def components(self) -> Sequence[Device]:
        """All devices beside the conveyor, along the belt."""
        return [self.source, *self.stations, self.sink]

    @property
    def placing(self) -> Sequence[str | None]:
        """Tasks of the source up to the one that places the item."""
        return _up_to(self.source, _PLACING)

    @property
    def taking(self) -> str | None:
        """The sink's task that takes the item out."""
        return self.sink.first(_TAKING) or self.sink.works[-1]


def plan_cell(sections: int, servers: Iterable[FoundServer], types: ActionTypes) -> Plan:
    """Return a starter cell of so many sections with what was found in it.

    :raises UnknownActionType: the types of the examples are not installed
    """
    devices, unusable = _usable(servers, types)
    example = _Examples(
        types, {device.name for device in devices} | {device.action for device in devices}
    )
    belt = _belt(devices)
    others = [device for device in devices if device is not belt]
    source = next((device for device in others if device.first(_PLACING)), None)
    sink = next(
        (device for device in others if device.first(_TAKING) and device is not source), None
    )
    rest = [device for device in others if device not in (source, sink)]
    belt = replace(belt, name=CONVEYOR) if belt else example.conveyor
    return Plan(
        sections,
        belt,
        _index_task(belt),
        replace(source or example.loader, section=1),
        [*_spread(rest, sections, example)],
        replace(sink or example.packer, section=sections),
        unusable,
    )


class _Examples:
    """Devices with the example interfaces."""

    def __init__(self, types: ActionTypes, taken: Collection[str]) -> None:
        """Prepare; no example gets a name or an action that is taken."""
        self._types = types
        self._taken = taken

    def device(self, name: str, type_name: str, ending: str = 'task') -> Device:
        while {name, f'/{name}/{ending}'} & {*self._taken}:
            name = f'example_{name}'
        type_ = self._types.action(f'{_PACKAGE}/{type_name}')
        return Device(name, f'/{name}/{ending}', type_)

    @property
    def conveyor(self) -> Device:
        return replace(self.device(CONVEYOR, 'Conveyor', 'index'), name=CONVEYOR)

    @property
    def loader(self) -> Device:
        return self.device('loader', 'UnpackingArm')

    @property
    def packer(self) -> Device:
        return self.device('packer', 'PackingArm')

    def station(self, section: int) -> Device:
        return replace(self.device(f'station_{section}', 'Component'), section=section)


def _usable(
    servers: Iterable[FoundServer], types: ActionTypes
) -> tuple[list[Device], list[FoundServer]]:
    devices: list[Device] = []
    unusable = []
    for server in sorted(servers, key=lambda server: server.action):
        name = _component_name(
            server.action, {device.name for device in devices} | {CONVEYOR, INDEX}
        )
        device = _device(name, server, types)
        if device is None:
            unusable.append(server)
        else:
            devices.append(device)
    return devices, unusable


def _device(name: str, server: FoundServer, types: ActionTypes) -> Device | None:
    """Return what serves an action; None if nothing is known that it could do."""
    try:
        device = Device(name, server.action, types.action(server.type), server)
    except UnknownActionType:
        return None
    return device if device.works else None


def _component_name(action: str, taken: Collection[str]) -> str:
    """Return the part of an action name that tells most: component_1a of /component_1a/task."""
    tokens = [token for token in action.split('/') if token]
    telling = [token for token in tokens if token.lower() not in _GENERIC] or tokens
    name = base = telling[-1]
    number = 2
    while name in taken:
        name, number = f'{base}_{number}', number + 1
    return name


def _belt(devices: Sequence[Device]) -> Device | None:
    """Return what looks most like the conveyor: by a task, else by a name."""
    indexing = (device for device in devices if device.first(_INDEX_WORDS[:1]))
    named = (
        device for device in devices if _BELT_WORDS & _parts(f'{device.action} {device.type.name}')
    )
    return next(indexing, None) or next(named, None)


def _index_task(belt: Device) -> str | None:
    named = (belt.first([word]) for word in _INDEX_WORDS)
    return next((task for task in named if task), belt.works[-1])


def _spread(others: Sequence[Device], sections: int, example: _Examples) -> Iterator[Device]:
    """Spread devices evenly over the sections between source and sink; examples where none is."""
    between = range(2, sections) or range(sections, sections + 1)
    by_section: Mapping[int, list[Device]] = {section: [] for section in between}
    for number, device in enumerate(others):
        section = between[number * len(between) // len(others)]
        by_section[section].append(replace(device, section=section))
    for section, devices in by_section.items():
        if devices or sections > 2:
            yield from devices or [example.station(section)]


def _up_to(device: Device, words: Collection[str]) -> Sequence[str | None]:
    last = device.first(words) or device.works[-1]
    return device.works[: device.works.index(last) + 1]


def _parts(name: str) -> set[str]:
    """Return the words of a name, in capitals: MOVE_ONE_INDEX, /belt/index, DriveTo."""
    spaced = re.sub(r'(?<=[a-z0-9])(?=[A-Z])', '_', name)
    return {part.upper() for part in re.split(r'[^A-Za-z0-9]+', spaced) if part}
