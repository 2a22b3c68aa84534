"""The projection of the state onto the py_trees blackboard, where guards and watchers read it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from py_trees.blackboard import Blackboard, Client
from py_trees.common import Access

from bt_orchestrator.model import events as e
from bt_orchestrator.model.state import CellState

_MOVES = (e.ItemPlaced, e.ItemMissing, e.ItemMoved, e.ItemRemoved, e.PositionEnded)

AT_REST = 'at rest'
MOVING = 'moving'


class ReadKey:
    """One key, as a guard reads it.

    A client of py_trees works out name and permission in every access, 8 us. Both are settled once
    here; while somebody watches the activity, the client is asked, which tells who read what.
    """

    def __init__(self, client: Client, key: str) -> None:
        client.register_key(key=key, access=Access.READ)
        self._client = client
        self._key = key
        self._name = client.absolute_name(key)

    def read(self) -> Any:
        """Return the value now."""
        if Blackboard.activity_stream is None:
            return Blackboard.storage[self._name]
        return self._client.get(self._key)


class BlackboardProjection:
    """The one writer of a cell's keys, all below `space`.

    `belt`, `beat`, `cell`; `flags/NAME` the count; `zones/NAME` and `components/NAME` the task
    that has it, or nothing; `ready/COMPONENT`; `slots/N` the item there, or nothing.
    """

    def __init__(self, space: str, state: CellState) -> None:
        self.space = space
        self._state = state
        self._client = Client(name=f'{space} state', namespace=space)
        self._names: dict[str, str] = {}
        """The whole name of every key that was set."""
        for key, value in self._everything():
            self._set(key, value)

    def follow(self, event: e.Event) -> None:
        """Set the keys that an event, already applied to the state, has changed."""
        for key, value in self._changed(event):
            self._set(key, value)

    def close(self) -> None:
        """Take the keys off the blackboard, which is global to the process."""
        for key in self._names:
            self._client.unset(key)
        self._client.unregister()

    def _set(self, key: str, value: Any) -> None:
        if key not in self._names:
            self._client.register_key(key=key, access=Access.EXCLUSIVE_WRITE)
            self._names[key] = self._client.absolute_name(key)
        if Blackboard.activity_stream is None:  # as in ReadKey
            Blackboard.storage[self._names[key]] = value
        else:
            self._client.set(key, value)

    def _everything(self) -> Iterator[tuple[str, Any]]:
        yield from self._belt()
        yield 'cell', self._state.mode.value
        for name in self._state.cell.components:
            yield self._component(name)
            yield self._ready(name)
        for number in self._state.sections:
            yield self._slot(number)
        for flag, counter in self._state.flags.items():
            yield f'flags/{flag}', counter.count
        for script in self._state.scripts.values():
            for zone in script.zones:
                yield self._zone(zone.name)

    def _changed(self, event: e.Event) -> Iterator[tuple[str, Any]]:
        if isinstance(event, e.FlagEvent):
            yield f'flags/{event.flag}', event.count
        elif isinstance(event, e.TaskEvent):
            yield from self._task(event)
        elif isinstance(event, (e.BeltIndexStarted, e.BeltIndexed, e.BeatStarted)):
            yield from self._belt()
        elif isinstance(event, _MOVES):
            yield from self._slots_around(event.section)
        elif isinstance(event, e.ComponentStateChanged):
            yield self._ready(event.component)
        elif isinstance(event, e.CellStateChanged):
            yield 'cell', event.state
        elif isinstance(event, (e.JobQueued, e.JobUpdated, e.HoldRaised, e.HoldReleased)):
            yield from self._everything()

    def _task(self, event: e.TaskEvent) -> Iterator[tuple[str, Any]]:
        task = self._state.task(event.key)
        if task is None:
            yield self._component(self._state.cell.conveyor.component.name)
            return
        yield self._component(task.component)
        assert event.job is not None
        for zone in self._state.script(event.job).zones_of.get(task.id, ()):
            yield self._zone(zone)

    def _belt(self) -> Iterator[tuple[str, Any]]:
        yield 'belt', MOVING if self._state.indexing else AT_REST
        yield 'beat', self._state.beat

    def _component(self, name: str) -> tuple[str, Any]:
        return f'components/{name}', str(self._state.reserved.get(name, ''))

    def _zone(self, name: str) -> tuple[str, Any]:
        return f'zones/{name}', str(self._state.zones.get(name, ''))

    def _ready(self, name: str) -> tuple[str, Any]:
        return f'ready/{name}', self._state.readings[name].ready

    def _slots_around(self, section: int | None) -> Iterator[tuple[str, Any]]:
        """Yield a slot that was filled or emptied, and the one before, which an item left."""
        for number in (section, (section or 0) - 1):
            if number in self._state.sections:
                yield self._slot(number)

    def _slot(self, number: int) -> tuple[str, Any]:
        return f'slots/{number}', self._state.sections[number].slot or ''
