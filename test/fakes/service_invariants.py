"""What holds of components out of service in every run, checked by a fold of its own (7.5)."""

from __future__ import annotations

from collections.abc import Mapping

from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.script import Script


class ServiceInvariants:
    """Follows the events of one cell and raises AssertionError at the first that cannot be."""

    def __init__(self, cell: Cell, scripts: Mapping[str, Script]) -> None:
        """Begin with everything in service.

        :param scripts: by digest, those that were loaded
        """
        self._cell, self._scripts = cell, scripts
        self._conveyor = cell.conveyor.component.name
        self._out: set[str] = set()
        self._queue: dict[str, str] = {}
        """Digests by job."""
        self._component: dict[e.TaskKey, str] = {}

    def take(self, event: e.Event) -> None:
        """Take in the next event."""
        if isinstance(event, e.TaskStarted):
            assert event.component not in self._out, event
            self._component[event.key] = event.component
        elif isinstance(event, e.TaskResent):
            assert self._component[event.key] not in self._out, event
        elif isinstance(event, e.BeltIndexStarted):
            assert self._conveyor not in self._out, event
        elif isinstance(event, e.ComponentOutOfService):
            assert event.component not in self._out, event
            self._out.add(event.component)
            need = [job for job in self._queue if event.component in self._needs(job)]
            assert sorted(event.jobs) == sorted(need), event
        elif isinstance(event, e.ComponentInService):
            self._out.remove(event.component)
        else:
            self._of_queue(event)

    def _of_queue(self, event: e.Event) -> None:
        if isinstance(event, e.OrderEvent):
            self._queue[event.job] = event.digest
            assert set(event.unavailable) == self._out & self._needs(event.job), event
        elif isinstance(event, e.JobStarted):
            assert not self._out & self._needs(event.job), event
            del self._queue[event.job]
        elif isinstance(event, (e.JobRemoved, e.JobAborting, e.JobCompleted, e.JobAborted)):
            self._queue.pop(event.job, None)

    def _needs(self, job: str) -> set[str]:
        script = self._scripts[self._queue[job]]
        listed = [task for section in script.sections.values() for task in section.tasks]
        return {self._conveyor, *(task.component for task in [*listed, *script.initialization])}
