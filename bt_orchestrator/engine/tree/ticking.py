"""Ticks as plain calls, equivalent to py_trees without memory.

py_trees passes each behaviour of a tick up through a generator of every ancestor, and formats a
log line at each: that was three quarters of a settle (docs/decisions/0020). The behaviours of a
cell follow the same rules in `run`, a plain call, with the same status, feedback and current
child. `tick` remains for other callers.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from py_trees import composites, decorators
from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status

SUCCESS, FAILURE, RUNNING, INVALID = (
    Status.SUCCESS,
    Status.FAILURE,
    Status.RUNNING,
    Status.INVALID,
)


class Ticked(Behaviour):
    """A behaviour that is ticked by `run`. A leaf defines `update`, as in py_trees."""

    children: list[Ticked]  # type: ignore[assignment]  # all behaviours of a cell are Ticked
    lasting = True
    """A success lasts until the branch is stopped: the parent's later ticks skip it. This holds
    for tasks, not for conditions. If the state resets a task (5.1), the whole tree restarts.
    """

    def __init__(self, name: str, *arguments: Any, **options: Any) -> None:
        # In pydot a colon separates node and port: without this, watchers merge nodes.
        super().__init__(name.replace(':', '\N{RATIO}'), *arguments, **options)

    def run(self) -> Status:
        """Tick this behaviour and its children as needed; return its status."""
        self.status = status = self.update()
        return status

    def tick(self) -> Iterator[Behaviour]:
        """Tick, and yield every active behaviour, children first."""
        self.run()
        yield from (
            behaviour for behaviour in self.iterate() if behaviour.status is not Status.INVALID
        )

    def tick_once(self) -> None:
        """Tick."""
        self.run()

    def stop(self, new_status: Status) -> None:
        """Set the status; INVALID: abandon the branch. This never cancels goals in flight."""
        if new_status is INVALID and self.children:
            invalidate(self.children)
        self.status = new_status


class Wrapper(Ticked, decorators.Decorator):
    """A decorator: it ticks its child, and `update` derives its own status."""

    decorated: Ticked

    def run(self) -> Status:
        """Tick the child, then look at it."""
        self.decorated.run()
        self.status = status = self.update()
        return status


class _Composite(Ticked, composites.Composite):
    """The common parts of composites."""

    def stop(self, new_status: Status = Status.INVALID) -> None:
        """Set the status; INVALID: abandon the branch."""
        if new_status is INVALID:
            self.current_child = None
            invalidate(self.children)
        self.status = new_status


class InOrder(_Composite, composites.Sequence):
    """One child after the other; non-lasting children are checked in every tick."""

    def __init__(self, name: str, children: Sequence[Ticked]) -> None:
        super().__init__(name, memory=False, children=children)
        self._all_last = all(child.lasting for child in children)
        self._at = 0
        """The last child that was ticked; those behind it are INVALID."""

    def run(self) -> Status:
        """Tick the children without a lasting success, until one has to wait."""
        children, before, first, status = self.children, 0, 0, SUCCESS
        if self.status is RUNNING:
            before = self._at
            first = before if self._all_last else 0
        elif self.status is not INVALID:
            invalidate(children)
        for at in range(first, len(children)):
            child = children[at]
            if child.status is not SUCCESS or not child.lasting:
                status = child.run()
                if status is not SUCCESS:
                    break
        if at < before:
            invalidate(children[at + 1 : before + 1])
        self._at, self.current_child, self.status = at, child, status
        return status


class AtOnce(_Composite, composites.Parallel):
    """All children together; succeeds with the last of them, and fails with the first."""

    def __init__(self, name: str, children: Sequence[Ticked]) -> None:
        # Not synchronised: a finished child counts only as long as the parallel goes on.
        super().__init__(name, ParallelPolicy.SuccessOnAll(synchronise=False), children)

    def run(self) -> Status:
        """Tick every child without a lasting success."""
        children = self.children
        if self.status is not RUNNING and self.status is not INVALID:
            invalidate(children)
        status, current = SUCCESS, children[-1]
        for child in children:
            if child.status is SUCCESS and child.lasting:
                continue
            child_status = child.run()
            if child_status is FAILURE and status is not FAILURE:
                status, current = FAILURE, child
            elif child_status is RUNNING and status is SUCCESS:
                status = RUNNING
        self.current_child, self.status = current, status
        if status is FAILURE:
            invalidate(child for child in children if child.status is RUNNING)
        return status


class FirstOf(_Composite, composites.Selector):
    """The first child that does not fail; all are checked in every tick."""

    def __init__(self, name: str, children: Sequence[Ticked]) -> None:
        super().__init__(name, memory=False, children=children)

    def run(self) -> Status:
        """Tick one child after the other until one does not fail."""
        status = FAILURE
        for number, child in enumerate(self.children):
            self.current_child = child
            status = child.run()
            if status is not FAILURE:
                invalidate(self.children[number + 1 :])
                break
        self.status = status
        return status


def invalidate(behaviours: Iterable[Ticked]) -> None:
    """Stop branches that are not ticked now."""
    for behaviour in behaviours:
        if behaviour.status is INVALID:
            continue
        if behaviour.children:
            behaviour.stop(INVALID)
        else:
            behaviour.status = INVALID
