"""What holds of initialization in every run, checked by a fold of its own (semantics 5)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any, ClassVar

from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.script import Script, Task

AS_DONE = 'done before'
"""Reason of a skip because of `once`."""


class InitializationInvariants:
    """Follows the events of one cell and raises AssertionError at the first that cannot be."""

    def __init__(self, cell: Cell, scripts: Mapping[str, Script]) -> None:
        """Look at a cell.

        :param scripts: those of the live jobs, by the names of the jobs
        """
        self._cell, self._scripts = cell, scripts
        self._open: dict[str, set[str]] = {}
        """Initialization to be done yet, of the jobs that have started, in that order."""
        self._last: dict[tuple[str, str], tuple[str | None, Mapping[str, Any] | None]] = {}
        """The last attempt of a task at an action: its job, and its arguments if it succeeded."""
        self._since_stopped: set[tuple[str, str]] = set()
        self._args: dict[e.TaskKey, Mapping[str, Any]] = {}
        self._as_done: dict[str, list[Task]] = {}
        self._place: dict[str | None, int] = {}
        """Of each job, in the order in which they started."""

    def take(self, event: e.Event) -> None:
        """Take in the next event."""
        for kind, take in self._takers.items():
            if isinstance(event, kind):
                take(self, event)

    def _job_started(self, event: e.JobStarted) -> None:
        script = self._scripts[event.job]
        self._place[event.job] = len(self._place)
        self._open[event.job] = {task.id for task in script.initialization}
        self._as_done[event.job] = []

    def _job_ended(self, event: e.JobCompleted | e.JobAborted) -> None:
        self._open.pop(event.job, None)

    def _started(self, event: e.TaskStarted) -> None:
        if event.job is None:
            return
        self._args[event.key] = event.args
        self._last[event.action, event.name] = event.job, None
        if event.section is None:
            for task in self._open_before(event.job):
                assert task.component != event.component, (event, task)

    def _done(self, event: e.TaskSucceeded | e.TaskMarkedDone) -> None:
        if event.job is None:
            return
        task = self._scripts[event.job].tasks[event.task]
        self._last[task.action, task.name] = event.job, self._args.get(event.key)
        self._since_stopped.add((task.action, task.name))

    def _passed(self, event: e.TaskEvent) -> None:
        if event.job in self._open and event.section is None:
            self._open[event.job].discard(event.task)

    def _skipped(self, event: e.TaskSkipped) -> None:
        if event.section is not None or event.job is None or event.reason != AS_DONE:
            return
        task = self._scripts[event.job].tasks[event.task]
        assert (task.action, task.name) in self._since_stopped, event
        if not task.refers:
            assert self._last[task.action, task.name][1] == task.args, event
            self._as_done[event.job].append(task)

    def _cycle(self, event: e.CycleStarted) -> None:
        for task in self._open_before(event.job):
            assert event.section not in self._places(task), (event, task)
        for task in self._as_done[event.job]:
            if event.section in self._places(task):
                job, args = self._last[task.action, task.name]
                is_of_earlier = self._place[job] < self._place[event.job]  # a later one may do it
                assert not is_of_earlier or args == task.args, (event, task)

    def _state_changed(self, event: e.CellStateChanged) -> None:
        if event.state in ('Stopped', 'Aborted'):
            self._since_stopped.clear()

    def _open_before(self, job: str) -> Iterator[Task]:
        for other_job, tasks in self._open.items():
            if other_job == job:
                return
            yield from (self._scripts[other_job].tasks[task] for task in tasks)

    def _places(self, task: Task) -> tuple[int, ...]:
        every = tuple(range(1, self._cell.conveyor.sections + 1))
        return self._cell.components[task.component].sections or every

    _takers: ClassVar[Mapping[type[e.Event] | tuple[type[e.Event], ...], Callable[..., None]]] = {
        e.JobStarted: _job_started,
        (e.JobCompleted, e.JobAborted): _job_ended,
        e.TaskStarted: _started,
        (e.TaskSucceeded, e.TaskMarkedDone): _done,
        e.TaskSkipped: _skipped,
        (e.TaskSucceeded, e.TaskMarkedDone, e.TaskSkipped, e.TaskContinued): _passed,
        e.CycleStarted: _cycle,
        e.CellStateChanged: _state_changed,
    }
