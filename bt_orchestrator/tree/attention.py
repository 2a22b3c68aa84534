"""Which parts of the tree an event can concern: the others need no tick.

A part that is not ticked keeps its status and its words, as if it had been ticked and found
everything as before. So a part may be left out only if no event since its last tick touches
anything it reads; when in doubt, everything is looked at again, from its first child on.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from heapq import heappop, heappush

from py_trees.common import Status

from bt_orchestrator.model import events as e
from bt_orchestrator.model.state import CellState
from bt_orchestrator.tree.ticking import AtOnce, Ticked
from bt_orchestrator.tree.turns import Turns

Part = int | str
"""A section by its number, or one of the two others by name."""

INITIALIZATION: Part = 'initialization'
BELT: Part = 'belt'

_TASKS = (
    e.TaskStarted,
    e.TaskAdopted,
    e.TaskResent,
    e.TaskCancelRequested,
    e.TaskSucceeded,
    e.TaskFailed,
    e.TaskRetrying,
    e.TaskSkipped,
    e.TaskContinued,
    e.TaskMarkedDone,
)

_CHANGE_SCRIPTS = (e.JobQueued, e.JobUpdated, e.JobRemoved, e.JobCompleted, e.JobAborted)


class Attention:
    """The parts that the next tick has to look at, by their places in a tick, from 0."""

    def __init__(self, state: CellState, turns: Turns, order: Iterable[Part]) -> None:
        """Consider everything due.

        :param order: of the parts in a tick
        """
        self._state = state
        self._turns = turns
        self._place = {part: place for place, part in enumerate(order)}
        self._all = range(len(self._place))
        self._due: set[int] = set()
        self._stale: set[int] = set()
        self._ahead: list[int] = []
        """A heap of what is due, and not yet passed in the tick that goes on."""
        self._at = math.inf
        self._concerns = self._table()
        self._index()
        self.again()

    def __bool__(self) -> bool:
        """Tell whether anything is due."""
        return bool(self._due)

    def walk(self) -> Iterator[tuple[int, bool]]:
        """Yield what is due, in order, and whether to begin there anew; it is then seen.

        What becomes due behind the present place is part of this tick, the rest of the next one.
        """
        self._ahead = sorted(self._due)
        while self._ahead:
            self._at = place = heappop(self._ahead)
            self._due.remove(place)
            stale = place in self._stale
            self._stale.discard(place)
            yield place, stale
        self._at = math.inf

    def everywhere(self) -> None:
        """Look at every part: time has come for something, or everybody's feedback changes."""
        self._mark(self._all)

    def again(self) -> None:
        """Look at every part from its first child on, whatever it has passed already."""
        self._turns.touch_all()
        self._stale.update(self._all)
        self._mark(self._all)

    def start_over(self) -> None:
        """Forget a tick that was cut short."""
        self._ahead.clear()
        self._at = math.inf
        self.again()

    def notice(self, event: e.Event) -> None:
        """Take note of an event that was applied to the state."""
        concern = self._concerns.get(type(event))
        if concern is not None:
            concern(event)
            return
        if isinstance(event, _CHANGE_SCRIPTS):
            self._index()
        self.again()

    def _mark(self, places: Iterable[int]) -> None:
        for place in places:
            if place not in self._due:
                self._due.add(place)
                if place > self._at:
                    heappush(self._ahead, place)

    # --- whom an event concerns --------------------------------------------------------------

    def _table(self) -> Mapping[type[e.Event], Callable[..., None]]:
        """Return what to do with an event, by its class; for any other, all is looked at again."""
        return {
            **dict.fromkeys((e.FlagRaised, e.FlagLowered), self._flag),
            **dict.fromkeys(_TASKS, self._task),
            **dict.fromkeys((e.CycleStarted, e.TurnCompleted, e.CycleCompleted), self._cycle),
            **dict.fromkeys((e.BeatStarted, e.BeltIndexStarted, e.BeltIndexed), self._belt),
            **dict.fromkeys(
                (e.ItemPlaced, e.ItemMissing, e.ItemRemoved, e.PositionEnded), self._slot
            ),
            e.ItemMoved: self._moved,
            e.ComponentStateChanged: self._component,
        }

    def _task(self, event: e.TaskEvent) -> None:
        # Initialization is not listed: every section may wait for it.
        self._mark(self._tasks.get((event.job, event.task), self._all))

    def _flag(self, event: e.FlagEvent) -> None:
        self._mark(self._flags[event.flag])

    def _component(self, event: e.ComponentStateChanged) -> None:
        self._mark(self._components[event.component])

    def _cycle(self, event: e.CycleEvent) -> None:
        self._turns.touch(event.section)
        self._mark((self._place[event.section], *self._ends))

    def _belt(self, _: e.Event) -> None:
        self._turns.touch_all()
        self.everywhere()

    def _moved(self, _: e.ItemMoved) -> None:
        """Wait for `belt.indexed`, which follows at once and concerns everybody."""

    def _slot(self, event: e.ItemPlaced | e.ItemMissing | e.ItemRemoved | e.PositionEnded) -> None:
        assert event.section is not None
        self._turns.touch(event.section)
        sections = self._state.sections.items()
        working = [n for n, s in sections if s.cycle is not None and s.cycle.item == event.item]
        around = (n for n in (event.section, event.section + 1) if n in self._place)
        self._mark(self._place[number] for number in (*around, *working))
        self._mark(self._ends)

    def _index(self) -> None:
        """Work out which parts share flags, zones and components, for the live jobs."""
        self._flags: dict[str, set[int]] = defaultdict(set)
        self._components: dict[str, set[int]] = defaultdict(set)
        zones: dict[str, set[int]] = defaultdict(set)
        scripts = self._state.scripts.values()
        for script in scripts:
            for task in script.tasks.values():
                place = self._place[script.section_of(task.id) or INITIALIZATION]
                self._components[task.component].add(place)
                for zone in script.zones_of.get(task.id, ()):
                    zones[zone].add(place)
            for dependency in script.dependencies:
                for end in (dependency.upstream, dependency.downstream):
                    self._flags[dependency.flag].add(self._place[script.section_of(end)])
        conveyor = self._components[self._state.cell.conveyor.component.name]
        conveyor.add(self._place[BELT])
        whole_line = (INITIALIZATION, *{script.source for script in scripts}, BELT)
        self._ends = tuple(self._place[part] for part in whole_line)
        """Places of what looks at the whole line: whether a job is through, whether a turn is."""
        self._tasks: dict[tuple[str | None, str], Iterable[int]] = {
            (None, e.INDEX_KEY.task): conveyor
        }
        for name, job in self._state.jobs.items():
            for number, tasks in job.job.script.sections.items():
                for task in tasks.tasks:
                    shared = (zones[zone] for zone in job.job.script.zones_of.get(task.id, ()))
                    places = {self._place[number], *self._components[task.component]}
                    self._tasks[name, task.id] = places.union(*shared)


class CellRoot(AtOnce):
    """The root: a parallel that never ends, and that ticks the parts that are due."""

    def __init__(self, name: str, parts: Sequence[Ticked], attention: Attention) -> None:
        super().__init__(name, parts)
        self._attention = attention

    def run(self) -> Status:
        """Tick the parts that are due, in order."""
        for place, is_stale in self._attention.walk():
            part = self.children[place]
            if is_stale:
                part.stop(Status.INVALID)
            part.run()
        self.current_child = self.children[-1]
        self.status = Status.RUNNING
        return self.status
