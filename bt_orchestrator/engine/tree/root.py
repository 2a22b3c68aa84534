"""The root of a cell's tree, and that tree as data."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.decorators import Decorator

from bt_orchestrator.engine.tree.attention import Attention
from bt_orchestrator.engine.tree.section import Section
from bt_orchestrator.engine.tree.subject import Recorder
from bt_orchestrator.engine.tree.ticking import AtOnce, Ticked
from bt_orchestrator.model.branch import Branch, Outcome
from bt_orchestrator.model.line import waits_without_work


class CellRoot(AtOnce):
    """A parallel that never ends and ticks only the due parts."""

    def __init__(
        self,
        recorder: Recorder,
        initialization: Ticked,
        sections: Mapping[int, Section],
        belt: Ticked,
        attention: Attention,
    ) -> None:
        name = recorder.state.cell.name
        super().__init__(name, [initialization, *sections.values(), belt])
        self._recorder = recorder
        self._sections = sections
        self._attention = attention
        self._parts = {1 << place: part for place, part in enumerate(self.children)}

    def run(self) -> Status:
        """Tick the due parts, in order.

        Parts that become due behind the present one belong to this tick, others to the next.
        """
        attention, ahead = self._attention, -1
        if attention.idle:
            self._tell(attention.take_idle())
        while todo := attention.due & ahead:
            bit = todo & -todo
            ahead = -bit << 1
            attention.due ^= bit
            part = self._parts[bit]
            if attention.stale and attention.stale & bit:
                attention.stale ^= bit
                part.stop(Status.INVALID)
            part.run()
        self.current_child = self.children[-1]
        self.status = Status.RUNNING
        return self.status

    def _tell(self, idle: Sequence[int]) -> None:
        state = self._recorder.state
        waits = [waits_without_work(state, has_item=has_item) for has_item in (False, True)]
        for number in idle:
            self._sections[number].tell(waits[state.sections[number].slot is not None])


# The behaviour tree as data.

_OUTCOMES = {
    Status.INVALID: Outcome.INVALID,
    Status.RUNNING: Outcome.RUNNING,
    Status.SUCCESS: Outcome.SUCCESS,
    Status.FAILURE: Outcome.FAILURE,
}


def branch_of(behaviour: Behaviour) -> Branch:
    """Return a behaviour with everything below it; not to be called while it is ticked."""
    active = behaviour.status is not Status.INVALID  # else the words are of its last tick
    return Branch(
        name=behaviour.name,
        status=_OUTCOMES[behaviour.status],
        words=str(behaviour.feedback_message) if active else '',
        is_decorator=isinstance(behaviour, Decorator),
        children=tuple(map(branch_of, behaviour.children)),
    )
