"""The things that behaviours share: the state they read, and their task."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Protocol

from bt_orchestrator.base.errors import MissingResult
from bt_orchestrator.model import events as e
from bt_orchestrator.model.condition import Condition, holds
from bt_orchestrator.model.judging.results import with_bounds
from bt_orchestrator.model.reference import Scope, look_up
from bt_orchestrator.model.script import Task
from bt_orchestrator.model.state import CellState, Cycle, Phase, TaskState
from bt_orchestrator.model.wait import Wait


class Recorder(Protocol):
    """Access of behaviours to the state and the events. The runtime implements it."""

    @property
    def state(self) -> CellState:
        """The state with every recorded event applied."""

    @property
    def now(self) -> float:
        """Time of this tick, seconds."""

    def record(self, events: Iterable[e.Event]) -> None:
        """Apply events in order, each before the next one is requested."""

    def new_goal_id(self) -> str:
        """Return a goal UUID that was never used."""

    def server(self, component: str) -> str | None:
        """Return the instance of a component's server that was seen last; None: not known."""

    def rivals(self, component: str) -> Sequence[str]:
        """Return the present servers of a component's action, if there are several."""

    @property
    def uptime(self) -> float | None:
        """How long the machine has been up, seconds; None: not known."""

    def is_delayed(self, key: e.TaskKey) -> bool:
        """Tell whether the next attempt of a task waits for its delay; a tick follows then."""

    def awaits_setup(self, key: e.TaskKey) -> bool:
        """Tell whether a task still waits for a state topic to tell its setup; a tick follows."""


class Subject:
    """The task of a leaf and of the decorators around it."""

    def __init__(
        self, recorder: Recorder, task: Task, job: str | None = None, section: int | None = None
    ) -> None:
        """Select a task.

        :param section: None for initialization and for the belt's own move
        """
        self.recorder = recorder
        self.task = task
        self.job = job
        self.section = section
        self._key = e.TaskKey(job, section, None, task.id)

    @property
    def state(self) -> CellState:
        """The state now."""
        return self.recorder.state

    @property
    def cycle(self) -> Cycle:
        """The cycle in hand of its section; called only during one."""
        assert self.section is not None
        cycle = self.recorder.state.sections[self.section].cycle
        assert cycle is not None, f'section {self.section} has no cycle'
        return cycle

    @property
    def key(self) -> e.TaskKey:
        """The task of the item that the section works on now."""
        if self.section is not None:
            cycle = self.recorder.state.sections[self.section].cycle
            assert cycle is not None, f'section {self.section} has no cycle'
            if cycle.item != self._key.item:  # constant during a cycle, and used often
                self._key = e.TaskKey(self.job, self.section, cycle.item, self.task.id)
        return self._key

    @property
    def progress(self) -> TaskState | None:
        """How far the task is; None: new."""
        return self.recorder.state.tasks.get(self.key)

    def with_bounds(self, condition: Condition) -> Condition:
        """Return a condition with the job's values in place of parameters, where it has them."""
        assert self.job is not None
        params = self.state.jobs[self.job].job.params
        try:
            return with_bounds(condition, Scope(params, order={}, item={}, results={}))
        except MissingResult:
            return condition  # a drawing has no order

    def missing(self) -> MissingResult | None:
        """Return a value that arguments, condition or verdict need, and this item lacks."""
        if not self.task.refers:
            return None
        scope = self.state.scope(self.key)
        try:
            if self.task.condition is not None:
                holds(self.task.condition, scope)
            for reference in self.task.references:
                look_up(reference, scope)
        except MissingResult as missing:
            return missing
        return None


def is_done(subject: Subject) -> bool:
    """Tell whether the cycle has passed the task."""
    return subject.state.phase(subject.key) is Phase.DONE


# Base of waiting behaviours: the wait as data, and as their feedback.


class Waiter:
    """A behaviour that may have to wait; a mixin for py_trees behaviours."""

    wait: Wait | None = None
    """The cause of its wait in its last tick; None: no wait."""
    feedback_message: str

    def note(self, wait: Wait | None) -> None:
        """Store what it waits for, and set the feedback."""
        self.wait = wait
        self.feedback_message = '' if wait is None else wait.reason
