"""Guards: decorators that block the start of a task, and say what it waits for.

A guard waits only while its task has an attempt to start. A task that runs, is done or will be
skipped passes, so a finished task is never blocked by its own flag. Nothing is reserved while
waiting (semantics 4.4): all guards of a task are checked in the tick that starts it.

Guards read the state. For viewers they register the blackboard keys that show what they read.
"""

from __future__ import annotations

from py_trees.common import Status

from bt_orchestrator.engine.tree.blackboard import name_keys
from bt_orchestrator.engine.tree.subject import Recorder, Subject, Waiter, is_done
from bt_orchestrator.engine.tree.ticking import Ticked, Wrapper, invalidate
from bt_orchestrator.model.cell import StateTopic
from bt_orchestrator.model.jobs.initialization import Preparation
from bt_orchestrator.model.script import Dependency, Step
from bt_orchestrator.model.wait import Wait
from bt_orchestrator.model.waits.starting import (
    waits_for_belt,
    waits_for_flag,
    waits_for_preparation,
    waits_for_topic,
    waits_for_zone,
)


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

    def waits_for(self) -> Wait | None:
        """Wait while the belt moves, or is at rest in the beat before this cycle's."""
        state = self._recorder.state
        cycle = state.sections[self._section].cycle
        assert cycle is not None
        wait = waits_for_belt(state, cycle)
        if wait is None or all(is_done(subject) for subject in self._subjects):
            return None
        return wait


class FlagGuard(Guard):
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
        return waits_for_flag(self.subject.state, self.subject.key, self.dependency)


class ZoneGuard(Guard):
    """A shared workspace (semantics 4.4)."""

    def __init__(self, subject: Subject, zone: str, child: Ticked, space: str) -> None:
        super().__init__(f'zone {zone} free', child)
        self.subject = subject
        self.zone = zone
        name_keys(self, f'{space}/zones', zone)

    def waits_for(self) -> Wait | None:
        """Wait while another task is in the zone; a held task keeps it until its new attempt."""
        subject = self.subject
        return waits_for_zone(subject.state, subject.key, subject.task, self.zone)


class ReadyGuard(Guard):
    """A component's state topic (semantics 2.5)."""

    def __init__(self, subject: Subject, topic: StateTopic, child: Ticked, space: str) -> None:
        super().__init__(f'{topic}', child)
        self.subject = subject
        name_keys(self, f'{space}/ready', subject.task.component)

    def waits_for(self) -> Wait | None:
        """Wait while the topic does not say ready."""
        return waits_for_topic(self.subject.state, self.subject.key, self.subject.task)


class InitializationGuard(Guard):
    """An initialization task waits for other tasks and for the jobs in front (semantics 5)."""

    def __init__(self, subject: Subject, preparation: Preparation, child: Ticked) -> None:
        upstream = preparation.upstream[subject.task.id]
        super().__init__(
            f'after {", ".join(upstream)}' if upstream else 'earlier jobs done', child
        )
        self.subject = subject

    def waits_for(self) -> Wait | None:
        """Wait for earlier tasks; a task that was begun, or ends with its job, does not wait."""
        return waits_for_preparation(self.subject.state, self.subject.key, self.subject.task)
