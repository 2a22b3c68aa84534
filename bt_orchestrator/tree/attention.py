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

from bt_orchestrator.model import events as e
from bt_orchestrator.model.events.tasks import TASK_EVENTS
from bt_orchestrator.model.state import CellState
from bt_orchestrator.tree.turns import Turns

Part = int | str
"""A section by its number, or one of the two others by name."""

INITIALIZATION: Part = 'initialization'
BELT: Part = 'belt'

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
        self._idle: list[int] = []
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

    def take_idle(self) -> Sequence[int]:
        """Return the sections for which nothing has changed but that the belt moves, or rests.

        In a line of 200 sections that is most of them, twice a beat. One may be due all the same.
        """
        idle, self._idle = self._idle, []
        return idle

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
            **dict.fromkeys(TASK_EVENTS, self._task),
            **dict.fromkeys((e.CycleStarted, e.TurnCompleted, e.CycleCompleted), self._cycle),
            **dict.fromkeys((e.BeatStarted, e.BeltIndexStarted, e.BeltIndexed), self._belt),
            **dict.fromkeys(
                (e.ItemPlaced, e.ItemMissing, e.ItemRemoved, e.PositionEnded), self._slot
            ),
            e.TaskStarted: self._started,
            e.ItemMoved: self._moved,
            e.ComponentStateChanged: self._component,
        }

    def _task(self, event: e.TaskEvent) -> None:
        # Initialization is not listed: every section may wait for it.
        self._mark(self._tasks.get((event.job, event.task), self._all))

    def _started(self, event: e.TaskStarted) -> None:
        """Mark the others: its own leaf, which has started it, says so already."""
        self._mark(self._others.get((event.job, event.task), self._all))

    def _flag(self, event: e.FlagEvent) -> None:
        self._mark(self._flags[event.flag])

    def _component(self, event: e.ComponentStateChanged) -> None:
        self._mark(self._components[event.component])

    def _cycle(self, event: e.CycleEvent) -> None:
        self._turns.touch(event.section)
        self._mark((self._place[event.section], *self._ends))

    def _belt(self, _: e.Event) -> None:
        """Mark where there is work for an item, or may be; all others wait for the belt alike."""
        self._idle.clear()
        coming = False
        for number, section in self._state.sections.items():
            there = section.slot is not None
            if number in self._working and (there or coming or section.cycle is not None):
                self._turns.touch(number)
                self._mark((self._place[number],))
            else:
                self._idle.append(number)
            coming = there
        self._mark(self._ends)

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
        self._working = {number for script in scripts for number in script.sections}
        self._ends = tuple(self._place[part] for part in whole_line)
        """Places of what looks at the whole line: whether a job is through, whether a turn is."""
        move: tuple[str | None, str] = (None, e.INDEX_KEY.task)
        self._tasks = {move: conveyor}
        self._others = {move: conveyor - {self._place[BELT]}}
        """As `_tasks`, without the section itself where nothing else can go on beside the task."""
        for name, job in self._state.jobs.items():
            for number, tasks in job.job.script.sections.items():
                own = {self._place[number]}
                for step in tasks.steps:
                    for task in step.tasks:
                        shared = (zones[z] for z in job.job.script.zones_of.get(task.id, ()))
                        places = own.union(self._components[task.component], *shared)
                        self._tasks[name, task.id] = places
                        self._others[name, task.id] = places if step.is_group else places - own
