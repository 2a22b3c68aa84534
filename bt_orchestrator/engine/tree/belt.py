"""The belt indexer: ends a beat when every turn is complete (semantics 3.4 to 3.6)."""

from __future__ import annotations

from collections.abc import Mapping

from py_trees.common import Status

from bt_orchestrator.engine.tree.subject import Recorder, Waiter
from bt_orchestrator.engine.tree.ticking import Ticked
from bt_orchestrator.model import events as e
from bt_orchestrator.model.failures import worded
from bt_orchestrator.model.line import Advance, Overrun, end_of_beat, feeding_job, owes_turn
from bt_orchestrator.model.state import CellState
from bt_orchestrator.model.wait import Wait, WaitKind
from bt_orchestrator.model.waits.starting import waits_for_one_server
from bt_orchestrator.model.words import OVERRUN


class TurnsComplete(Ticked, Waiter):
    """Condition: the belt moves, or every section has released it; never fails."""

    lasting = False

    def __init__(self, recorder: Recorder, turns: Turns) -> None:
        super().__init__('all turns complete')
        self.recorder = recorder
        self._turns = turns

    def update(self) -> Status:
        """Begin the move or the next beat when it is due; wait with the reason otherwise."""
        state = self.recorder.state
        self.note(None)
        if state.indexing:
            return Status.SUCCESS
        due: Advance | Overrun | Wait = end_of_beat(state, self._turns.owing())
        if due is Advance.INDEX:
            conveyor = state.cell.conveyor.component.name
            due = waits_for_one_server(state, conveyor, self.recorder) or due
        if isinstance(due, Overrun):
            self._hold(due.item)
        elif isinstance(due, Wait):
            self.note(due)
        elif due is Advance.INDEX:
            self.recorder.record([e.BeltIndexStarted(beat=state.beat)])
            return Status.SUCCESS
        else:
            self.recorder.record([e.BeatStarted(beat=state.beat + 1)])
            self.feedback_message = 'next beat begins, the belt is empty'
        return Status.RUNNING

    def _hold(self, item: str) -> None:
        state = self.recorder.state
        if not any(hold.reason == OVERRUN for hold in state.holds.values()):
            section = state.cell.conveyor.sections
            held = e.HoldRaised(
                hold=state.next_hold,
                job=state.items[item].job,
                section=section,
                item=item,
                reason=OVERRUN,
                answers=('remove_item',),
            )
            self.recorder.record([worded(state, held)])
        what = f'waiting for {item} to be removed'
        self.note(Wait(what, WaitKind.HOLD, item, sections=(state.cell.conveyor.sections,)))


# The sections that owe a turn in this beat (semantics 3.4), computed only after changes.


class Turns:
    """Cache of `model.line.owes_turn`, updated by the events.

    The belt checks every section after every step of every cycle; in a line of 200 sections that
    was a third of a settle.
    """

    def __init__(self, state: CellState) -> None:
        self._state = state
        self._touched = set(state.sections)
        self._owing: dict[int, str] = {}

    def touch(self, section: int) -> None:
        """Invalidate a section: its cycle, its turn or its slot has changed."""
        self._touched.add(section)

    def touch_all(self) -> None:
        """Invalidate every section: the beat or anything else has changed."""
        self._touched.update(self._state.sections)

    def owing(self) -> Mapping[int, str]:
        """Return what each section still has to do, by its number, ascending."""
        # Whether the source may begin depends also on jobs, holds and initialization.
        feeding = feeding_job(self._state)
        if feeding is not None:
            self._touched.add(feeding.job.script.source)
        state, owing = self._state, self._owing
        self._touched.update(owing)
        for number in self._touched:
            owed = owes_turn(state, state.sections[number])
            if owed is not None:
                owing[number] = owed
            elif number in owing:
                del owing[number]
        self._touched.clear()
        return dict(sorted(owing.items())) if len(owing) > 1 else owing
