"""Selects the parts of the tree that an event can affect; only these are ticked.

A part that is not ticked keeps its status and feedback, as if a tick had found no change. So a
part may be left out only if no event since its last tick changes anything it reads; in doubt,
everything is ticked again, from its first child.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from heapq import heappop, heappush

from bt_orchestrator.model import events as e
from bt_orchestrator.model.events.tasks import TASK_EVENTS
from bt_orchestrator.model.state import CellState
from bt_orchestrator.tree.sharing import Part, Sharing
from bt_orchestrator.tree.turns import Turns

_OF_NO_PART = (
    *(e.JobQueued, e.JobMoved, e.JobHeld, e.JobReleased, e.JobMayStart, e.JobRemoved),
    *(e.JobCleared, e.ScriptLoaded, e.OperatorDecided, e.OperatorRefused),
    *(e.ItemNonconforming, e.ItemIdentified),
)
"""Events that affect no part; if they change which jobs are at work, branches are added."""


class Attention:
    """The parts that are due in the next tick, by their places in a tick, from 0."""

    def __init__(self, state: CellState, turns: Turns, order: Iterable[Part]) -> None:
        """Mark everything as due.

        :param order: the parts, in the order of a tick
        """
        self._state = state
        self._turns = turns
        self._place = {part: place for place, part in enumerate(order)}
        self._all = range(len(self._place))
        self._due: set[int] = set()
        self._stale: set[int] = set()
        self._ahead: list[int] = []
        """A heap of the parts that are due and not yet passed in the current tick."""
        self._idle: list[int] = []
        self._at = math.inf
        self._concerns = self._table()
        self.sharing = Sharing(state.cell, self._place)
        """Updated by the code that compiles branches."""
        self.again()

    def __bool__(self) -> bool:
        """Tell whether anything is due."""
        return bool(self._due)

    def walk(self) -> Iterator[tuple[int, bool]]:
        """Yield the due parts in order, and whether to restart each from its first child.

        Parts that become due behind the present place belong to this tick, others to the next.
        """
        self._ahead = sorted(self._due)
        while self._ahead:
            self._at = place = heappop(self._ahead)
            self._due.remove(place)
            stale = bool(self._stale) and place in self._stale
            if stale:
                self._stale.remove(place)
            yield place, stale
        self._at = math.inf

    def take_idle(self) -> Sequence[int]:
        """Return the sections for which only the belt's state, moving or at rest, has changed.

        In a line of 200 sections that is most of them, twice per beat. One may still be due.
        """
        idle, self._idle = self._idle, []
        return idle

    def everywhere(self) -> None:
        """Mark every part as due: a deadline has come, or the feedback of all changes."""
        self._mark(self._all)

    def again(self) -> None:
        """Mark every part as due from its first child, whatever it has passed already."""
        self._turns.touch_all()
        self._stale.update(self._all)
        self._mark(self._all)

    def start_over(self) -> None:
        """Discard an interrupted tick."""
        self._ahead.clear()
        self._at = math.inf
        self.again()

    def notice(self, event: e.Event) -> None:
        """Take note of an event that was applied to the state."""
        concern = self._concerns.get(type(event))
        if concern is not None:
            concern(event)
        else:
            self.again()

    def _mark(self, places: Iterable[int]) -> None:
        fresh = set(places).difference(self._due)
        self._due.update(fresh)
        if fresh and self._at is not math.inf:  # within a tick
            for place in fresh:
                if place > self._at:
                    heappush(self._ahead, place)

    # --- the parts affected by an event ------------------------------------------------------

    def _table(self) -> Mapping[type[e.Event], Callable[..., None]]:
        """Return the handler of each event class; for any other class everything is due."""
        return {
            **dict.fromkeys(_OF_NO_PART, lambda _: None),
            **dict.fromkeys((e.FlagRaised, e.FlagLowered), self._flag),
            **dict.fromkeys(TASK_EVENTS, self._task),
            **dict.fromkeys((e.CycleStarted, e.TurnCompleted, e.CycleCompleted), self._cycle),
            **dict.fromkeys((e.BeatStarted, e.BeltIndexStarted, e.BeltIndexed), self._belt),
            **dict.fromkeys(
                (e.ItemPlaced, e.ItemMissing, e.ItemRemoved, e.PositionEnded), self._slot
            ),
            e.TaskStarted: self._started,
            e.ClockStepped: lambda _: None,
            e.ItemMoved: self._moved,
            **dict.fromkeys((e.ComponentStateChanged, e.ComponentContested), self._component),
        }

    def _task(self, event: e.TaskEvent) -> None:
        self._mark_some(
            self.sharing.move()
            if event.job is None
            else self.sharing.task(self._state.jobs[event.job].digest, event.task)
        )

    def _started(self, event: e.TaskStarted) -> None:
        """Mark the other parts: the task's own leaf already shows the start."""
        self._mark_some(
            self.sharing.beside_move()
            if event.job is None
            else self.sharing.beside_task(self._state.jobs[event.job].digest, event.task)
        )

    def _mark_some(self, places: Iterable[int] | None) -> None:
        self._mark(self._all if places is None else places)

    def _flag(self, event: e.FlagEvent) -> None:
        self._mark(self.sharing.flag(event.flag))

    def _component(self, event: e.ComponentStateChanged | e.ComponentContested) -> None:
        self._mark(self.sharing.component(event.component))

    def _cycle(self, event: e.CycleEvent) -> None:
        self._turns.touch(event.section)
        self._mark((self._place[event.section], *self.sharing.ends))

    def _belt(self, _: e.Event) -> None:
        """Mark parts with possible work for an item; all others just wait for the belt."""
        self._idle.clear()
        coming = False
        for number, section in self._state.sections.items():
            there = section.slot is not None
            if self.sharing.works(number) and (there or coming or section.cycle is not None):
                self._turns.touch(number)
                self._mark((self._place[number],))
            else:
                self._idle.append(number)
            coming = there
        self._mark(self.sharing.ends)

    def _moved(self, _: e.ItemMoved) -> None:
        """Do nothing: `belt.indexed` follows at once and affects all parts."""

    def _slot(self, event: e.ItemPlaced | e.ItemMissing | e.ItemRemoved | e.PositionEnded) -> None:
        assert event.section is not None
        self._turns.touch(event.section)
        sections = self._state.sections.items()
        working = [n for n, s in sections if s.cycle is not None and s.cycle.item == event.item]
        around = (n for n in (event.section, event.section + 1) if n in self._place)
        self._mark(self._place[number] for number in (*around, *working))
        self._mark(self.sharing.ends)
