"""What py_trees_ros' tree is told around a settle: tried on the class of py_trees it extends."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from uuid import UUID

from py_trees.behaviours import Failure, Running, Success
from py_trees.common import Status
from py_trees.composites import Selector
from py_trees.trees import BehaviourTree
from py_trees.visitors import SnapshotVisitor, VisitorBase

from bt_orchestrator.ros.inspection.start import LibraryTree


class Log:
    """A logger that keeps what it is told."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def error(self, message: str) -> None:
        self.lines.append(message)

    def warning(self, message: str) -> None:
        self.lines.append(message)


class Visits(VisitorBase):
    """Counts what it is shown."""

    def __init__(self, *, full: bool) -> None:
        super().__init__(full=full)
        self.names: list[str] = []

    def run(self, behaviour: object) -> None:
        self.names.append(getattr(behaviour, 'name', ''))


class Bench:
    """A tree that is ticked by us alone, with what py_trees_ros' class has besides py_trees'."""

    def __init__(self) -> None:
        self.first = Failure('first')
        self.root = Selector('root', False, [self.first, Running('busy'), Success('never')])
        self.tree = BehaviourTree(self.root)
        self.tree.snapshot_streams = {'/s': object()}  # type: ignore[attr-defined]
        self.tree.blackboard_exchange = SimpleNamespace(views=[])  # type: ignore[attr-defined]
        self.visitor = SnapshotVisitor()
        self.tree.visitors.append(self.visitor)
        self.log = Log()
        self.told: list[str] = []
        self.tree.pre_tick_handlers.append(lambda tree: self.told.append('before'))
        self.tree.post_tick_handlers.append(lambda tree: self.told.append('after'))
        library = LibraryTree(self.tree, lambda: self.root, self.log)
        self.settle: Callable[[], bool] = library.around(self._settle)

    def _settle(self) -> bool:
        self.told.append('settle')
        self.root.tick_once()
        return len(self.told) == 2

    def seen(self) -> set[UUID]:
        return set(self.visitor.visited)

    def leave(self) -> None:
        self.tree.snapshot_streams.clear()  # type: ignore[attr-defined]


def test_settle_visits_same_behaviours_as_a_tick() -> None:
    bench, twin = Bench(), Bench()
    assert bench.settle(), 'what a settle says is handed on'
    twin.tree.tick()

    assert bench.told == ['before', 'settle', 'after']
    assert bench.tree.count == twin.tree.count == 1
    names = [{b.name for b in rig.root.iterate() if b.id in rig.seen()} for rig in (bench, twin)]
    assert names[0] == names[1] == {'root', 'first', 'busy'}
    assert bench.visitor.changed
    assert not bench.settle()
    assert not bench.visitor.changed


def test_the_tree_is_not_ticked_by_it() -> None:
    bench = Bench()
    LibraryTree(bench.tree, lambda: bench.root, bench.log).around(lambda: False)()
    assert bench.told == ['before', 'after']
    assert {b.status for b in bench.root.iterate()} == {Status.INVALID}
    assert bench.seen() == set()


def test_full_visitors_are_shown_everything() -> None:
    bench, full = Bench(), Visits(full=True)
    bench.tree.visitors.append(full)
    bench.settle()
    assert sorted(full.names) == ['busy', 'first', 'never', 'root']


def test_nobody_watches_nothing_is_done_but_once_more() -> None:
    bench = Bench()
    bench.settle()
    bench.leave()
    bench.settle()  # so that the activity stream is switched off
    assert bench.told == ['before', 'settle', 'after'] * 2
    bench.settle()
    assert bench.told == ['before', 'settle', 'after'] * 2 + ['settle']


def test_library_fault_is_reported_and_stops_nothing() -> None:
    bench = Bench()

    def broken(tree: object) -> None:
        raise KeyError('stream')

    bench.tree.post_tick_handlers.insert(0, broken)
    bench.settle()
    bench.settle()
    assert bench.told == ['before', 'settle'] * 2
    assert len(bench.log.lines) == 2
    assert "KeyError: 'stream'" in bench.log.lines[0]


def test_a_tree_built_anew_is_shown() -> None:
    bench = Bench()
    bench.settle()
    bench.root = Selector('new', False, [Running('other')])
    bench.settle()
    assert {b.name for b in bench.root.iterate() if b.id in bench.seen()} == {'new', 'other'}
