"""Copies the state to the py_trees blackboard: for tree viewers, not for behaviours."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.blackboard import Blackboard, Client
from py_trees.common import Access

from bt_orchestrator.model import events as e
from bt_orchestrator.model.state import CellState

AT_REST = 'at rest'
MOVING = 'moving'


def name_keys(behaviour: Behaviour, namespace: str, *keys: str) -> None:
    """Register for viewers the keys that show what a behaviour reads from the state."""
    client = behaviour.attach_blackboard_client(name=behaviour.name, namespace=namespace)
    for key in keys:
        client.register_key(key=key, access=Access.READ)


class BlackboardProjection:
    """The only writer of a cell's keys, all below `space`. Implements `ports.EventSink`.

    `belt`, `beat`, `cell`; `flags/NAME`: the count; `zones/NAME` and `components/NAME`: the task
    that has it, or nothing; `ready/COMPONENT`; `slots/N`: the item there, or nothing.
    """

    def __init__(self, space: str, state: CellState) -> None:
        self.space = space
        self._state = state
        self._client = Client(name=f'{space} state', namespace=space)
        self._names: dict[str, str] = {}
        """The full name of every key that was set."""
        self._zones = {z.name for script in state.scripts.values() for z in script.zones}
        self._taken: tuple[dict[str, e.TaskKey], dict[str, e.TaskKey]] = {}, {}
        """The components and zones that are shown as taken."""
        self._acts = self._table()
        self._everything()

    def publish(self, events: Sequence[e.Event]) -> None:
        """Set the keys that events, already applied to the state, have changed."""
        for event in events:
            act = self._acts.get(type(event))
            if act is not None:
                act(event)
        self._show_taken()

    def close(self) -> None:
        """Remove the keys from the blackboard, which is global to the process."""
        for key in self._names:
            self._client.unset(key)
        self._client.unregister()

    def _set(self, key: str, value: Any) -> None:
        if key not in self._names:
            self._client.register_key(key=key, access=Access.EXCLUSIVE_WRITE)
            self._names[key] = self._client.absolute_name(key)
        # A py_trees client checks name and permission in every access, 8 us; it is used only
        # while a viewer watches, for the activity record.
        if Blackboard.activity_stream is None:
            Blackboard.storage[self._names[key]] = value
        else:
            self._client.set(key, value)

    # --- changes by events -------------------------------------------------------------------

    def _table(self) -> Mapping[type[e.Event], Callable[..., None]]:
        """Return the handler of each event class."""
        moves = (e.ItemPlaced, e.ItemMissing, e.ItemMoved, e.ItemRemoved, e.PositionEnded)
        scripts, holds = (e.JobQueued, e.JobUpdated), (e.HoldRaised, e.HoldReleased)
        return {
            **dict.fromkeys((e.FlagRaised, e.FlagLowered), self._flag),
            **dict.fromkeys((e.BeltIndexStarted, e.BeltIndexed, e.BeatStarted), self._belt),
            **dict.fromkeys(moves, self._slots_around),
            **dict.fromkeys(scripts, lambda event: self._script(event.digest)),
            **dict.fromkeys((*holds, e.RoundBegun), self._everything),
            e.ComponentStateChanged: lambda event: self._ready(event.component),
            e.CellStateChanged: self._cell,
        }

    def _everything(self, _: e.Event | None = None) -> None:
        self._belt()
        self._cell()
        for name in self._state.cell.components:
            self._component(name)
            self._ready(name)
        for number in self._state.sections:
            self._slot(number)
        for flag, counter in self._state.flags.items():
            self._set(f'flags/{flag}', counter.count)
        for zone in self._zones:
            self._zone(zone)

    def _script(self, digest: str) -> None:
        """Set the keys of a script's flags and zones; it may reset a flag."""
        script = self._state.scripts.get(digest)
        if script is None:
            return
        for dependency in script.dependencies:
            self._set(f'flags/{dependency.flag}', self._state.flags[dependency.flag].count)
        for zone in script.zones:
            self._zones.add(zone.name)
            self._zone(zone.name)

    def _flag(self, event: e.FlagEvent) -> None:
        self._set(f'flags/{event.flag}', event.count)

    def _show_taken(self) -> None:
        state, (components, zones) = self._state, self._taken
        for name, _ in state.reserved.items() ^ components.items():
            self._component(name)
        for name, _ in state.zones.items() ^ zones.items():
            self._zone(name)
        self._taken = dict(state.reserved), dict(state.zones)

    def _belt(self, _: e.Event | None = None) -> None:
        self._set('belt', MOVING if self._state.indexing else AT_REST)
        self._set('beat', self._state.beat)

    def _cell(self, _: e.Event | None = None) -> None:
        self._set('cell', self._state.packml.value)

    def _slots_around(self, event: e.ItemPlaced | e.ItemMoved | e.ItemRemoved) -> None:
        """Set a slot that was filled or emptied, and the one before, which an item left."""
        section = event.section or 0
        for number in (section, section - 1):
            if number in self._state.sections:
                self._slot(number)

    # --- keys --------------------------------------------------------------------------------

    def _component(self, name: str) -> None:
        self._set(f'components/{name}', str(self._state.reserved.get(name, '')))

    def _zone(self, name: str) -> None:
        self._set(f'zones/{name}', str(self._state.zones.get(name, '')))

    def _ready(self, name: str) -> None:
        self._set(f'ready/{name}', self._state.readings[name].ready)

    def _slot(self, number: int) -> None:
        self._set(f'slots/{number}', self._state.sections[number].slot or '')
