"""Guards: decorators that block the start of a task, and say what it waits for.

A guard waits only while its task has an attempt to start. A task that runs, is done or will be
skipped passes, so a finished task is never blocked by its own flag. Nothing is reserved while
waiting (semantics 4.4): all guards of a task are checked in the tick that starts it.

Guards read the state. For viewers they register the blackboard keys that show what they read.
"""

from __future__ import annotations

from py_trees.common import Status

from bt_orchestrator.model import effects
from bt_orchestrator.model.cell import StateTopic
from bt_orchestrator.model.initialization import Preparation
from bt_orchestrator.model.jobs.preparing import may_not_prepare, remains_done, waits_for_its_turn
from bt_orchestrator.model.line import waits_for_readiness
from bt_orchestrator.model.script import Dependency, Step
from bt_orchestrator.model.wait import Wait, WaitKind
from bt_orchestrator.tree.blackboard import name_keys
from bt_orchestrator.tree.subject import Recorder, Subject, holder, is_done, section_of
from bt_orchestrator.tree.ticking import Ticked, Wrapper, invalidate
from bt_orchestrator.tree.waiter import TaskWaiter, Waiter


class Guard(Wrapper, Waiter):
    """Base: ticks its child unless it has to wait."""

    def waits_for(self) -> Wait | None:
        """Return the condition that must hold before the child may be ticked; None: none."""
        raise AssertionError(f'{type(self).__name__} guards nothing')

    def run(self) -> Status:
        """Wait RUNNING with the reason, or tick the child and return its status."""
        wait = self.waits_for()
        if wait is not self.wait:
            self.note(wait)
        if wait is None:
            self.status = status = self.decorated.run()
            return status
        invalidate(self.children)
        self.status = Status.RUNNING
        return self.status

    def update(self) -> Status:
        """Return the child's status."""
        return self.decorated.status


class ConveyorGuard(Guard):
    """A step that requires the conveyor waits for the belt to rest, in the step's own beat.

    Semantics 3.3 and 3.7.
    """

    def __init__(
        self, recorder: Recorder, job: str, section: int, step: Step, child: Ticked, space: str
    ) -> None:
        super().__init__('belt at rest', child)
        self._subjects = [Subject(recorder, task, job, section) for task in step.tasks]
        self._section = section
        self._recorder = recorder
        name_keys(self, space, 'belt', 'beat')

    @property
    def components(self) -> tuple[str, ...]:
        """The components of all tasks of the step."""
        return tuple(dict.fromkeys(subject.task.component for subject in self._subjects))

    def waits_for(self) -> Wait | None:
        """Wait while the belt moves, or is at rest in the beat before this cycle's."""
        state = self._recorder.state
        cycle = state.sections[self._section].cycle
        assert cycle is not None
        rests = not state.indexing
        if rests and state.beat == cycle.beat:
            return None
        if all(is_done(subject) for subject in self._subjects):
            return None
        return Wait(f'waiting for the belt to {"move" if rests else "rest"}', WaitKind.BELT)


class FlagGuard(TaskWaiter, Guard):
    """A lateral dependency's flag (semantics 4.1); also for a task that will be skipped (4.2)."""

    def __init__(
        self, subject: Subject, dependency: Dependency, child: Ticked, space: str
    ) -> None:
        self.upstream = dependency.upstream == subject.task.id
        bound = f'< {dependency.capacity}' if self.upstream else '> 0'
        super().__init__(f'flag {dependency.flag} {bound}', child)
        self.subject = subject
        self.dependency = dependency
        name_keys(self, f'{space}/flags', dependency.flag)

    def waits_for(self) -> Wait | None:
        """Wait while the count does not allow the task."""
        if not effects.is_startable(self.subject.state, self.subject.key):
            return None
        count = self.subject.state.flags[self.dependency.flag].count
        if self.upstream:
            full = count >= self.dependency.capacity
            return self._until(self.dependency.downstream, 'take') if full else None
        return self._until(self.dependency.upstream, 'set') if count <= 0 else None

    def _until(self, task: str, does: str) -> Wait:
        flag, job = self.dependency.flag, self.subject.job
        assert job is not None
        section = self.subject.state.script(job).section_of(task)
        what = f'waiting for {task} to {does} flag {flag}'
        return Wait(what, WaitKind.FLAG, flag, (section,), task)


class ZoneGuard(TaskWaiter, Guard):
    """A shared workspace (semantics 4.4)."""

    def __init__(self, subject: Subject, zone: str, child: Ticked, space: str) -> None:
        super().__init__(f'zone {zone} free', child)
        self.subject = subject
        self.zone = zone
        name_keys(self, f'{space}/zones', zone)

    def waits_for(self) -> Wait | None:
        """Wait while another task is in the zone; a held task keeps it until its new attempt."""
        state = self.subject.state
        there = state.zones.get(self.zone)
        if there is None or there == self.subject.key or not self.subject.waits_to_start:
            return None
        what = f'waiting for zone {self.zone}, taken by {holder(state, there)}'
        return Wait(what, WaitKind.ZONE, self.zone, section_of(there), there.task)


class ReadyGuard(TaskWaiter, Guard):
    """A component's state topic (semantics 2.5)."""

    def __init__(self, subject: Subject, topic: StateTopic, child: Ticked, space: str) -> None:
        super().__init__(f'{topic}', child)
        self.subject = subject
        name_keys(self, f'{space}/ready', subject.task.component)

    def waits_for(self) -> Wait | None:
        """Wait while the topic does not say ready."""
        wait = waits_for_readiness(self.subject.state, self.subject.task.component)
        return wait if wait is not None and self.subject.waits_to_start else None


class InitializationGuard(TaskWaiter, Guard):
    """An initialization task waits for other tasks and for the jobs in front (semantics 5)."""

    def __init__(self, subject: Subject, preparation: Preparation, child: Ticked) -> None:
        upstream = preparation.upstream[subject.task.id]
        super().__init__(
            f'after {", ".join(upstream)}' if upstream else 'earlier jobs done', child
        )
        self.subject = subject

    def waits_for(self) -> Wait | None:
        """Wait for earlier tasks; a task that was begun, or ends with its job, does not wait."""
        job, state, task = self.subject.job, self.subject.state, self.subject.task
        assert job is not None
        if state.phase(self.subject.key) is not None or self.subject.ends_with_its_job():
            return None
        stopped = may_not_prepare(state, job)
        if stopped is not None:
            return stopped
        if self.subject.done_before() is not None and remains_done(state, job, task):
            return None
        return waits_for_its_turn(state, job, task)
