"""The belt indexer: ends a beat when every turn is complete (semantics 3.5, 3.6)."""

from __future__ import annotations

from py_trees.common import Status

from bt_orchestrator.engine.tree.subject import Recorder
from bt_orchestrator.engine.tree.ticking import Ticked
from bt_orchestrator.engine.tree.turns import Turns
from bt_orchestrator.engine.tree.waiter import Waiter
from bt_orchestrator.model import events as e
from bt_orchestrator.model.failures import worded
from bt_orchestrator.model.line import Advance, Overrun, end_of_beat
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
