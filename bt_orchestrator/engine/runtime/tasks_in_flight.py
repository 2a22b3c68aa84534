"""The tasks with a goal in flight, as a status shows them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property

from bt_orchestrator.engine.runtime.engine import Engine, Goals
from bt_orchestrator.engine.runtime.feedback import feedback_text
from bt_orchestrator.engine.runtime.observed_durations import ObservedDurations
from bt_orchestrator.model.events import INDEX_KEY, TaskKey
from bt_orchestrator.model.limits import FEEDBACK_BYTES
from bt_orchestrator.model.state import JobState, TaskState
from bt_orchestrator.model.status import TaskStatus


class TasksInFlight:
    """All of them at one moment, by place."""

    def __init__(self, engine: Engine, durations: ObservedDurations) -> None:
        self._engine = engine
        self._durations = durations

    def of_belt(self) -> tuple[TaskStatus, ...]:
        """Return the belt's own move."""
        return self._of([INDEX_KEY])

    def of_section(self, number: int) -> tuple[TaskStatus, ...]:
        """Return the tasks of a section."""
        return self._of(self._by_section.get(number, ()))

    def of_initialization(self, job: JobState) -> tuple[TaskStatus, ...]:
        """Return the initialization tasks of a job."""
        tasks = job.job.script.initialization if job.started else ()
        return self._of(TaskKey(job.job.id, None, None, task.id) for task in tasks)

    @cached_property
    def _by_section(self) -> Mapping[int | None, Sequence[TaskKey]]:
        found: dict[int | None, list[TaskKey]] = defaultdict(list)
        for key in self._engine.state.running:
            found[key.section].append(key)
        return found

    def _of(self, keys: Iterable[TaskKey]) -> tuple[TaskStatus, ...]:
        running = self._engine.state.running
        return tuple(self._status(key, running[key]) for key in keys if key in running)

    def _status(self, key: TaskKey, progress: TaskState) -> TaskStatus:
        state = self._engine.state
        task, conveyor = state.task(key), state.cell.conveyor
        name = task.name if task else conveyor.task
        component = task.component if task else conveyor.component.name
        return TaskStatus(
            id=key.task,
            name=name,
            component=component,
            action=task.action if task else conveyor.component.action,
            attempt=progress.attempt,
            goal=progress.goal or '',
            started=progress.started,
            expected_s=self._expected_s(component, name),
            feedback=feedback_of(self._engine.flights, progress.goal),
            round=state.round(key),
        )

    def _expected_s(self, component: str, name: str) -> float | None:
        observed_s = self._durations.usual_s(component, name)
        if observed_s is not None:
            return observed_s
        known = self._engine.state.cell.components.get(component)
        return None if known is None else known.duration_s(name)


def feedback_of(flights: Goals, goal: str | None) -> str:
    """Return the last feedback of a goal as a JSON object, shortened if it is long."""
    flight = flights.goal(goal) if goal else None
    return feedback_text(flight.feedback, FEEDBACK_BYTES) if flight else ''
