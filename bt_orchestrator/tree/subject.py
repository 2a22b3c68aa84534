"""What behaviours share: the state they read, and their task."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Protocol

from bt_orchestrator.errors import MissingResult
from bt_orchestrator.model import effects
from bt_orchestrator.model import events as e
from bt_orchestrator.model.condition import Condition, holds
from bt_orchestrator.model.hold_words import hold_wait_words
from bt_orchestrator.model.judging.verdict import with_bounds
from bt_orchestrator.model.reference import Scope, look_up, resolve
from bt_orchestrator.model.script import Task
from bt_orchestrator.model.state import (
    CellState,
    Cycle,
    Phase,
    TaskState,
    same_args,
    same_task,
)
from bt_orchestrator.model.wait import Wait, WaitKind


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

    @property
    def waits_to_start(self) -> bool:
        """Tell whether the next step is to start an attempt: neither begun nor to be skipped."""
        return effects.is_startable(self.state, self.key) and self.why_skipped() is None

    @property
    def could_go_on(self) -> bool:
        """Tell whether no pause and no hold of its section blocks the task."""
        return not self.state.pauses and self.waits_in_hold() is None

    def why_skipped(self) -> str | None:
        """Say why a task that may start is not needed (semantics 4.2, 5.1, 6.4, 6.5)."""
        if self.job is None:
            return None
        return (
            effects.why_skipped(self.state, self.key, self.task)
            or self.done_before()
            or self._unmet(self.task.condition)
        )

    def ends_with_its_job(self) -> bool:
        """Tell whether it is an initialization task of a job that is ending (6.6).

        Nothing waits for it, so it is skipped whatever the state of the cell.
        """
        if self.section is not None or self.job is None:
            return False
        return effects.why_skipped(self.state, self.key, self.task) is not None

    def done_before(self) -> str | None:
        """Say that the same task is already done and need not be repeated (5.1)."""
        if not self.task.once:
            return None
        args = resolve(self.task.args, self.state.scope(self.key))
        done = self.state.done_once.get(same_task(self.task))
        return 'done before' if done == same_args(args) else None

    def _unmet(self, condition: Condition | None) -> str | None:
        """Say that a condition is not met. If a value is missing, the attempt fails instead."""
        if condition is None:
            return None
        try:
            return None if holds(condition, self.state.scope(self.key)) else str(condition)
        except MissingResult:
            return None

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

    def stopped(self) -> Wait | None:
        """Say why the task must not start or be skipped: a skip counts as if it had run."""
        if not self.state.works:
            mode = self.state.packml.value
            what = 'the node ends' if self.state.shutting_down else f'the cell is {mode}'
            return Wait(what, WaitKind.CELL_STATE, mode)
        if self.state.pauses:
            first = self.state.pauses[0]
            return Wait(hold_wait_words([first]), WaitKind.PAUSE, first.id)
        return self.waits_in_hold()

    def waits_in_hold(self) -> Wait | None:
        """Return the wait for a hold that blocks this task's section (semantics 7.1)."""
        for hold in self.state.holds.values():
            same = (
                not hold.is_pause
                and hold.section == self.section
                and (hold.job is None) == (self.job is None)
            )
            if same:
                return Wait(hold_wait_words([hold]), WaitKind.HOLD, hold.id)
        return None


def holder(state: CellState, key: e.TaskKey) -> str:
    """Name the task that has a component or a zone, and why, if its goal does not run."""
    has = state.tasks[key]
    if has.phase is Phase.HELD:
        return f'{key}, which waits for an answer to hold {has.hold}'
    if has.phase is Phase.RETRYING:
        return f'{key}, which is to be tried again'
    return str(key)


def section_of(key: e.TaskKey) -> tuple[int, ...]:
    """Return the section that works on a task; none for initialization and the belt's move."""
    return () if key.section is None else (key.section,)


def is_done(subject: Subject) -> bool:
    """Tell whether the cycle has passed the task."""
    return subject.state.phase(subject.key) is Phase.DONE
