"""Compiles cell and scripts to one behaviour tree, as a pure function.

    parallel CELL
      parallel initialization   one branch a job: its tasks behind their guards
      selector section S … 1    one branch a job: condition, steps, release, trailing steps, end;
                                last, what begins the next cycle
      sequence belt             all turns complete, then the index move

The order of the children decides ties: initialization first, then the downstream section
(semantics 4.4). Nothing has memory: each tick reads the state again.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial

from py_trees.common import Status
from py_trees.composites import Composite

from bt_orchestrator.engine.tree.attention import Attention, Notice
from bt_orchestrator.engine.tree.belt import Turns, TurnsComplete
from bt_orchestrator.engine.tree.guards import (
    ConveyorGuard,
    FlagGuard,
    InitializationGuard,
    ReadyGuard,
    ZoneGuard,
)
from bt_orchestrator.engine.tree.leaf import ActionLeaf
from bt_orchestrator.engine.tree.policies import (
    Conditional,
    OnFailureDecorator,
    Retry,
    Rounds,
    Verdict,
)
from bt_orchestrator.engine.tree.root import CellRoot
from bt_orchestrator.engine.tree.section import (
    CompleteCycle,
    CycleOf,
    ListPage,
    ReleaseConveyor,
    Section,
    detach,
    is_long,
    paged,
)
from bt_orchestrator.engine.tree.sharing import BELT, INITIALIZATION
from bt_orchestrator.engine.tree.subject import Recorder, Subject
from bt_orchestrator.engine.tree.ticking import AtOnce, InOrder, Ticked
from bt_orchestrator.model import events as e
from bt_orchestrator.model.script import SectionList, Step, Task, index_task
from bt_orchestrator.model.state import JobState


class CellTree:
    """The tree of a cell, with branches for the jobs that can do anything.

    These are the ones on the line and the next one of the queue (`LiveJobs.at_work`), so the tree
    is as large with ten thousand waiting jobs as with one. Branches are changed between ticks.
    Before its first cycle a job needs them only for its initialization; the first tick of a cycle
    in progress is the one after the cycle's start.
    """

    def __init__(self, recorder: Recorder, space: str, *, whole: bool = False) -> None:
        """Compile a tree for the jobs that the state has now.

        :param space: namespace of the cell's keys on the blackboard
        :param whole: compile long lists completely, without pages
        """
        self.recorder = recorder
        self._space = space
        self._whole = whole
        state = recorder.state
        self.initialization = AtOnce('initialization', [Standby('standby')])
        self.sections = {
            number: Section(recorder, number) for number in sorted(state.sections, reverse=True)
        }
        subject = Subject(recorder, index_task(state.cell))
        move = self._ready(subject, _decided(subject))
        turns = Turns(state)
        self.belt = InOrder('belt', [TurnsComplete(recorder, turns), move])
        self._attention = Attention(state, turns, (INITIALIZATION, *self.sections, BELT))
        self.root = CellRoot(
            recorder, self.initialization, self.sections, self.belt, self._attention
        )
        self._branches: dict[str, list[Ticked]] = {}
        self._compiled: dict[str, tuple[str, Mapping[str, object]]] = {}
        """Digest of the script, and parameters, that the branches of a job were compiled from."""
        self._to_follow = True
        """The jobs at work may have changed since the last tick."""
        self.follow_jobs()
        self.root.setup_with_descendants()

    @property
    def is_due(self) -> bool:
        """Tell whether a change requires another tick."""
        return self._attention.due != 0

    def tick(self) -> None:
        """Tick every part that is affected by a change since its last tick."""
        self.follow_jobs()
        try:
            self.root.tick_once()
        except BaseException:
            self._attention.again()
            raise

    def notices(self, kind: type[e.Event]) -> Iterator[Notice]:
        """Yield what takes note of each event of a class, once it is applied to the state."""
        notice = self._attention.notice_of(kind)
        if notice is not None:
            yield notice
        if kind in _AT_WORK:
            yield self._note_jobs

    def notice_time(self) -> None:
        """Note that a wake-up time requested by a part has come."""
        self._attention.everywhere()

    def has(self, job: str) -> bool:
        """Tell whether a job has branches in the tree."""
        return job in self._branches

    def follow_jobs(self) -> None:
        """Update the branches to the jobs at work, in their order. Only between ticks."""
        if not self._to_follow:
            return
        self._to_follow = False
        jobs = {job.job.id: job for job in self.recorder.state.jobs.at_work()}
        for name, compiled in list(self._compiled.items()):
            if name not in jobs or _source(jobs[name]) != compiled:
                self.prune(name)
        for name, job in jobs.items():
            if name not in self._branches:
                self.insert(job)
        if list(self._branches) != list(jobs):
            self._arrange(list(jobs))

    def insert(self, job: JobState) -> None:
        """Add the branches of a job, behind those of earlier jobs. Only between ticks."""
        branches = self._branches[job.job.id] = []
        self._compiled[job.job.id] = _source(job)
        self._attention.sharing.enter(job.digest, job.job.script)
        self._attention.again()
        if job.job.script.initialization:
            branch = self._initialization(job)
            self._insert(branch, self.initialization)
            branches.append(branch)
        for number, tasks in job.job.script.sections.items():
            branch = self._cycle(job.job.id, tasks)
            self._insert(branch, self.sections[number])
            branches.append(branch)

    def prune(self, job: str) -> None:
        """Remove the branches of a job. Only between ticks."""
        self._attention.sharing.leave(self._compiled.pop(job)[0])
        self._attention.again()
        for branch in self._branches.pop(job):
            parent = branch.parent
            assert isinstance(parent, Composite)
            parent.remove_child(branch)
            for behaviour in branch.iterate():
                detach(behaviour)

    def close(self) -> None:
        """Release the tree and its blackboard clients."""
        for behaviour in self.root.iterate():
            detach(behaviour)

    def _note_jobs(self, _: e.Event) -> None:
        self._to_follow = True

    def _arrange(self, jobs: list[str]) -> None:
        """Sort the branches by the order of the jobs; those without a job stay last."""
        self._branches = {name: self._branches[name] for name in jobs}
        place = {b: n for n, name in enumerate(jobs) for b in self._branches[name]}
        for part in (self.initialization, *self.sections.values()):
            part.children.sort(key=lambda child: place.get(child, len(jobs)))

    @staticmethod
    def _insert(branch: Ticked, parent: Composite) -> None:
        parent.insert_child(branch, len(parent.children) - 1)
        branch.setup_with_descendants()

    # --- initialization ---------------------------------------------------------------------

    def _initialization(self, job: JobState) -> Ticked:
        preparation = self.recorder.state.preparations[job.digest]
        children: list[Ticked] = []
        for task in job.job.script.initialization:
            subject = Subject(self.recorder, task, job.job.id)
            guarded = self._shared(job.job.id, subject)
            children.append(InitializationGuard(subject, preparation, guarded))
        return AtOnce(job.job.id, children)

    # --- sections ---------------------------------------------------------------------------

    def _cycle(self, job: str, tasks: SectionList) -> Ticked:
        return InOrder(
            job,
            [
                CycleOf(self.recorder, tasks.section, job),
                *self._steps(job, tasks.section, tasks.steps[: tasks.turn_steps]),
                ReleaseConveyor(self.recorder, tasks.section),
                *self._steps(job, tasks.section, tasks.steps[tasks.turn_steps :]),
                CompleteCycle(self.recorder, tasks.section),
            ],
        )

    def _steps(self, job: str, section: int, steps: Sequence[Step]) -> list[Ticked]:
        def compiled(part: Sequence[Step]) -> list[Ticked]:
            return [self._step(job, section, step) for step in part]

        if not self._in_pages(job):
            return compiled(steps)
        return [
            ListPage(
                [task for step in part for task in step.tasks],
                partial(compiled, part),
                [self._subject(job, section, task) for task in part[-1].tasks],
            )
            for part in paged(steps, lambda step: sum(map(len, step.tracks)))
        ]

    def _step(self, job: str, section: int, step: Step) -> Ticked:
        tracks = [self._track(job, section, track) for track in step.tracks]
        body = AtOnce('parallel', tracks) if step.is_group else tracks[0]
        if not step.requires_conveyor:
            return body
        return ConveyorGuard(self.recorder, job, section, step, body, self._space)

    def _track(self, job: str, section: int, track: tuple[Task, ...]) -> Ticked:
        repeat = self.recorder.state.script(job).repeat_of.get(track[0].id)
        tasks = self._in_order(job, section, track)
        if repeat is None:
            return tasks
        return Rounds(self._subject(job, section, track[0]), repeat, tasks)

    def _in_order(self, job: str, section: int, track: tuple[Task, ...]) -> Ticked:
        def compiled(part: Sequence[Task]) -> list[Ticked]:
            return [self._task(self._subject(job, section, task)) for task in part]

        if len(track) == 1:
            return compiled(track)[0]
        if not self._in_pages(job):
            return InOrder('in order', compiled(track))
        pages = [
            ListPage(part, partial(compiled, part), [self._subject(job, section, part[-1])])
            for part in paged(track, lambda _: 1)
        ]
        return InOrder('in order', pages)

    def _subject(self, job: str, section: int, task: Task) -> Subject:
        return Subject(self.recorder, task, job, section)

    def _in_pages(self, job: str) -> bool:
        return not self._whole and is_long(self.recorder.state.script(job))

    def _task(self, subject: Subject) -> Ticked:
        assert subject.job is not None
        script = self.recorder.state.script(subject.job)
        task = subject.task.id
        behaviour = self._shared(subject.job, subject)
        flags = (*script.upstream_of.get(task, ()), *script.downstream_of.get(task, ()))
        for dependency in flags:
            behaviour = FlagGuard(subject, dependency, behaviour, self._space)
        return behaviour

    def _shared(self, job: str, subject: Subject) -> Ticked:
        """Compile a task with the guards for shared resources: ready component, zones (4.4)."""
        behaviour = self._ready(subject, _decided(subject))
        for zone in self.recorder.state.script(job).zones_of.get(subject.task.id, ()):
            behaviour = ZoneGuard(subject, zone, behaviour, self._space)
        return behaviour

    def _ready(self, subject: Subject, behaviour: Ticked) -> Ticked:
        topic = self.recorder.state.cell.components[subject.task.component].state
        return behaviour if topic is None else ReadyGuard(subject, topic, behaviour, self._space)


_AT_WORK = {
    *(e.JobQueued, e.JobMoved, e.JobUpdated, e.JobHeld, e.JobReleased, e.JobRemoved),
    *(e.ComponentOutOfService, e.ComponentInService, e.ScriptReleased, e.QueueArranged),
    *(e.JobMayStart, e.JobStarted, e.JobAborting, e.JobCompleted, e.JobAborted),
}
"""Events after which other jobs may be at work."""


def _source(job: JobState) -> tuple[str, Mapping[str, object]]:
    """Return what the branches of a job are compiled from."""
    return job.digest, job.job.params


def _decided(subject: Subject) -> Ticked:
    """Compile a task's leaf, with the decorators that handle its failures."""
    leaf: Ticked = ActionLeaf(subject)
    if subject.task.fails_unless is not None:
        leaf = Verdict(subject, leaf)
    if subject.task.retries:
        leaf = Retry(subject, leaf)
    decided = OnFailureDecorator(subject, leaf)
    return decided if subject.task.condition is None else Conditional(subject, decided)


class Standby(Ticked):
    """Keeps an idle part RUNNING: the root never ends."""

    def update(self) -> Status:
        """Go on."""
        return Status.RUNNING
