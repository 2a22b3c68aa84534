"""Selects the parts of the tree that an event can affect; only these are ticked.

A part that is not ticked keeps its status and feedback, as if a tick had found no change. So a
part may be left out only if no event since its last tick changes anything it reads; in doubt,
everything is ticked again, from its first child.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

from bt_orchestrator.engine.tree.belt import Turns
from bt_orchestrator.engine.tree.sharing import BELT, Concern, Part, Parts, Sharing
from bt_orchestrator.model import events as e
from bt_orchestrator.model.events.tasks import TASK_EVENTS
from bt_orchestrator.model.state import CellState

Notice = Callable[[Any], None]
"""Takes note of an event of one class that was applied to the state."""

_OF_NO_PART = (
    *(e.JobQueued, e.JobMoved, e.JobHeld, e.JobReleased, e.JobMayStart, e.JobRemoved),
    *(e.JobCleared, e.ScriptLoaded, e.OperatorDecided, e.OperatorRefused),
    *(
        e.ControlChanged,
        e.UnitModeChanged,
        e.RequestSigned,
        e.ItemNonconforming,
        e.ItemIdentified,
        e.ClockStepped,
        e.ItemMoved,
        e.QueueArranged,
    ),
)
"""Events that affect no part. If they change which jobs are at work, branches are added; after
`item.moved` `belt.indexed` follows at once and affects all parts."""


class Attention:
    """The parts that are due in the next tick, as bits: the first part has the lowest."""

    def __init__(self, state: CellState, turns: Turns, order: Iterable[Part]) -> None:
        """Mark everything as due.

        :param order: the parts, in the order of a tick
        """
        self._state = state
        self._turns = turns
        self._bits = {part: 1 << place for place, part in enumerate(order)}
        self._belt_bit = self._bits[BELT]
        self._all: Parts = (1 << len(self._bits)) - 1
        self.due: Parts = 0
        self.stale: Parts = 0
        """The parts that restart from their first child."""
        self.idle: list[int] = []
        self._notices = self._table()
        self.sharing = Sharing(state.cell, self._bits)
        """Updated by the code that compiles branches."""
        self._concerns: dict[tuple[str | None, str], Concern] = {}
        """Cache by job and task."""
        self.again()

    def take_idle(self) -> Sequence[int]:
        """Return the sections for which only the belt's state, moving or at rest, has changed.

        In a line of 200 sections that is most of them, twice per beat. One may still be due.
        """
        idle, self.idle = self.idle, []
        return idle

    def everywhere(self) -> None:
        """Mark every part as due: a deadline has come, or the feedback of all changes."""
        self.due = self._all

    def again(self, _: e.Event | None = None) -> None:
        """Mark every part as due from its first child, whatever it has passed already."""
        self._turns.touch_all()
        self._concerns.clear()
        self.due = self.stale = self._all

    def notice_of(self, kind: type[e.Event]) -> Notice | None:
        """Return what takes note of a class of events; None: they affect no part."""
        return self._notices.get(kind, self.again)

    # --- the parts affected by an event ------------------------------------------------------

    def _table(self) -> Mapping[type[e.Event], Notice | None]:
        """Return the handler of each event class; for any other class everything is due."""
        return {
            **dict.fromkeys(_OF_NO_PART),
            **dict.fromkeys((e.FlagRaised, e.FlagLowered), self._flag),
            **dict.fromkeys(TASK_EVENTS, self._task),
            **dict.fromkeys((e.CycleStarted, e.TurnCompleted, e.CycleCompleted), self._cycle),
            **dict.fromkeys((e.BeatStarted, e.BeltIndexStarted, e.BeltIndexed), self._belt),
            **dict.fromkeys(
                (e.ItemPlaced, e.ItemMissing, e.ItemRemoved, e.PositionEnded), self._slot
            ),
            e.TaskStarted: self._started,
            e.TaskRetrying: self._retrying,
            e.ComponentStateChanged: self._component,
            e.ComponentContested: self._contested,
        }

    def _task(self, event: e.TaskEvent) -> None:
        concern = self._concerns.get((event.job, event.task))
        self.due |= (concern or self._concern(event)).all

    def _started(self, event: e.TaskStarted) -> None:
        concern = self._concerns.get((event.job, event.task))
        self.due |= (concern or self._concern(event)).beside

    def _retrying(self, event: e.TaskRetrying) -> None:
        """Restart the initialization too: a change that is done may be asked for again (5.3)."""
        if event.section is None and event.job is not None:
            self.again()
        else:
            self._task(event)

    def _concern(self, event: e.TaskEvent) -> Concern:
        if event.key == e.MANUAL_KEY:
            own_concern: Concern | None = None
        elif event.job is None:
            own_concern = self.sharing.move()
        else:
            own_concern = self.sharing.task(self._state.jobs[event.job].digest, event.task)
        concern = Concern(self._all, self._all) if own_concern is None else own_concern
        self._concerns[event.job, event.task] = concern
        return concern

    def _ends(self) -> Parts:
        """Return the parts that check the whole line: for ends of jobs, and ends of turns.

        A source in a cycle, and a belt that moves, do not look at other parts.
        """
        state, sharing = self._state, self.sharing
        ends = 1 if sharing.prepares else 0  # the initialization is the first part
        if not state.indexing:
            ends |= self._belt_bit
        for number in sharing.sources:
            if state.sections[number].cycle is None:
                ends |= self._bits[number]
        return ends

    def _flag(self, event: e.FlagEvent) -> None:
        self.due |= self.sharing.flag(event.flag)

    def _component(self, event: e.ComponentStateChanged | e.ComponentContested) -> None:
        self.due |= self.sharing.component(event.component)

    def _contested(self, event: e.ComponentContested) -> None:
        """Restart all where setups are forgotten by it (5.3): changes may be to be done again."""
        if self._state.cell.components[event.component].setups:
            self.again()
        else:
            self._component(event)

    def _cycle(self, event: e.CycleEvent) -> None:
        self._turns.touch(event.section)
        self.due |= self._bits[event.section] | self._ends()

    def _belt(self, _: e.Event) -> None:
        """Mark parts with possible work for an item; all others just wait for the belt."""
        self.idle.clear()
        coming = False
        for number, section in self._state.sections.items():
            there = section.slot is not None
            if self.sharing.works(number) and (there or coming or section.cycle is not None):
                self._turns.touch(number)
                self.due |= self._bits[number]
            else:
                self.idle.append(number)
            coming = there
        self.due |= self._ends()

    def _slot(self, event: e.ItemPlaced | e.ItemMissing | e.ItemRemoved | e.PositionEnded) -> None:
        assert event.section is not None
        self._turns.touch(event.section)
        self.due |= self._ends() | self._bits[event.section]
        self.due |= self._bits.get(event.section + 1, 0)
        for number, section in self._state.sections.items():
            if section.cycle is not None and section.cycle.item == event.item:
                self.due |= self._bits[number]
