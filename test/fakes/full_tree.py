"""Trees that leave nothing out, to compare with one that does."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.composites import Composite

from bt_orchestrator.engine.runtime.ledger import Ledger
from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.engine.tree.compile import CellTree
from bt_orchestrator.model.events import Event, TaskKey
from bt_orchestrator.model.state import CellState


class FullTree(CellTree):
    """Ticks every part from its first child on, in every tick, until nothing happens any more."""

    _seq = -1
    """Last event before the last tick."""

    @property
    def is_due(self) -> bool:
        return self.recorder.state.seq != self._seq

    def tick(self) -> None:
        self._seq = self.recorder.state.seq
        self._attention.again()
        super().tick()

    def notice_time(self) -> None:
        self._seq = -1


class _Reader:
    """A recorder for a tree that has nothing to decide."""

    def __init__(self, ledger: Ledger) -> None:
        self._ledger = ledger

    @property
    def state(self) -> CellState:
        return self._ledger.state

    @property
    def now(self) -> float:
        return self._ledger.now

    def record(self, events: Iterable[Event]) -> None:
        recorded = list(events)
        assert not recorded, f'a part was left out that had something to do: {recorded}'

    def new_goal_id(self) -> str:
        raise AssertionError('a part was left out that had a goal to send')

    def server(self, component: str) -> str | None:
        return self._ledger.server(component)

    def rivals(self, component: str) -> Sequence[str]:
        return self._ledger.rivals(component)

    @property
    def uptime(self) -> float | None:
        return self._ledger.uptime

    def is_delayed(self, key: TaskKey) -> bool:
        """Wake nobody: whoever waits has asked already."""
        return self._ledger.is_delayed(key)

    def awaits_setup(self, key: TaskKey) -> bool:
        return self._ledger.awaits_setup(key)


def check_view(orchestrator: Orchestrator) -> None:
    """Fail unless the tree looks like one that is compiled now and ticked as a whole.

    Call it after a settle.
    """
    reader = _Reader(orchestrator._ledger)
    fresh = CellTree(reader, orchestrator._projection.space)
    fresh.follow_jobs()
    fresh.tick()
    assert view(orchestrator.tree.root) == view(fresh.root), f'at {reader.now} s'
    fresh.close()


def view(behaviour: Behaviour, depth: int = 0) -> list[tuple[int, str, Status, str, str]]:
    """Return what a watcher sees: status, words of all that is gone through, current children."""
    seen = behaviour.status is not Status.INVALID
    current = behaviour.current_child if isinstance(behaviour, Composite) else None
    row = (
        depth,
        behaviour.name,
        behaviour.status,
        behaviour.feedback_message if seen else '',
        current.name if current is not None else '',
    )
    return [row, *(below for child in behaviour.children for below in view(child, depth + 1))]
