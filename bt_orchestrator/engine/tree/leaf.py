"""The action leaf: one task, as one goal after another until it is done."""

from __future__ import annotations

from py_trees.common import Status

from bt_orchestrator.engine.tree.subject import Subject, Waiter
from bt_orchestrator.engine.tree.ticking import Ticked
from bt_orchestrator.model import effects
from bt_orchestrator.model import events as e
from bt_orchestrator.model.failures import RETRY, worded
from bt_orchestrator.model.goal import Reason
from bt_orchestrator.model.hold_words import again_words, hold_wait_words
from bt_orchestrator.model.jobs.setups import missing_setup
from bt_orchestrator.model.reference import resolve
from bt_orchestrator.model.state import End, Phase, TaskState
from bt_orchestrator.model.wait import Wait, WaitKind
from bt_orchestrator.model.waits.starting import before_attempt
from bt_orchestrator.model.words import SLOT_OCCUPIED


class ActionLeaf(Waiter, Ticked):
    """One task at one action server.

    Its states: new (it starts when nothing blocks it), RUNNING while its goal is in flight or an
    operator is asked, FAILURE while a failed attempt waits for the decision of the decorators
    above, SUCCESS once the cycle has passed it. It stores none of that itself but reads the state,
    so a leaf built during a goal continues where the old one stopped. `terminate` never cancels a
    goal; only a recorded decision does.
    """

    def __init__(self, subject: Subject) -> None:
        task = subject.task
        super().__init__(task.name if task.id == task.name else f'{task.id} ({task.name})')
        self.subject = subject

    @property
    def in_flight(self) -> bool:
        """Tell whether the leaf is RUNNING because its goal is."""
        progress = self.subject.progress
        return progress is not None and progress.phase is Phase.RUNNING

    def update(self) -> Status:
        """Check the task's phase, and start it if it may."""
        self.note(None)
        progress = self.subject.progress
        if progress is None or progress.phase is Phase.RETRYING:
            return self._start_if_free(progress)
        return self._report(progress)

    def _report(self, progress: TaskState) -> Status:
        if progress.phase is Phase.RUNNING:
            further = self.subject.state.round(self.subject.key)
            self.feedback_message = self._running(progress.attempt, further)
            return Status.RUNNING
        if progress.phase is Phase.HELD:
            hold = self.subject.state.holds[progress.hold or '']
            self.note(Wait(hold_wait_words([hold]), WaitKind.HOLD, hold.id))
            return Status.RUNNING
        if progress.phase is Phase.FAILED:
            self.feedback_message = f'failed: {progress.reason.value if progress.reason else ""}'
            return Status.FAILURE
        self.feedback_message = _ended(progress)
        return Status.SUCCESS

    def _start_if_free(self, progress: TaskState | None) -> Status:
        subject = self.subject
        obstacle = before_attempt(subject.state, subject.key, subject.task, subject.recorder)
        if isinstance(obstacle, str):
            return self._skip(obstacle)
        if obstacle is not None:
            self.note(obstacle)
            return Status.RUNNING
        return self._start(1 if progress is None else progress.attempt + 1)

    def _skip(self, reason: str) -> Status:
        key = self.subject.key
        self._begin_job()
        self.subject.recorder.record([e.TaskSkipped(**key._asdict(), reason=reason)])
        self.subject.recorder.record(effects.of_passing(self.subject.state, key))
        self.feedback_message = f'skipped: {reason}'
        return Status.SUCCESS

    def _start(self, attempt: int) -> Status:
        recorder, task, key = self.subject.recorder, self.subject.task, self.subject.key
        missing = self.subject.missing() if self.subject.job is not None else None
        if missing is not None:
            return self._fail(attempt, Reason.MISSING_RESULT, str(missing))
        if task.setup and (other := missing_setup(self.subject.state, task)) is not None:
            return self._fail(attempt, Reason.SETUP_MISSING, other)
        occupied = self._occupied()
        if occupied is not None:
            recorder.record([occupied])
            return Status.RUNNING
        self._begin_job()
        further = self.subject.state.round(key)
        started = e.TaskStarted(
            **key._asdict(),
            name=task.name,
            action=task.action,
            component=task.component,
            attempt=attempt,
            goal=recorder.new_goal_id(),
            args=self._args(),
            server=recorder.server(task.component),
            uptime=recorder.uptime,
            round=further,
        )
        recorder.record([started])
        self.feedback_message = self._running(attempt, further)
        return Status.RUNNING

    def _fail(self, attempt: int, reason: Reason, message: str) -> Status:
        """Let an attempt end before a goal."""
        key = self.subject.key
        failed = e.TaskFailed(
            **key._asdict(),
            attempt=attempt,
            reason=reason.value,
            message=message,
            round=self.subject.state.round(key),
        )
        self.subject.recorder.record([failed])
        self.feedback_message = f'failed: {message}'
        return Status.FAILURE

    def _begin_job(self) -> None:
        """Start the job with its first task (semantics 6.1)."""
        job = None if self.subject.job is None else self.subject.state.jobs[self.subject.job]
        if job is not None and not job.started and not job.ending:
            self.subject.recorder.record([e.JobStarted(job=job.job.id)])

    def _running(self, attempt: int, further: int) -> str:
        words = again_words(further, attempt)
        where = f'running at {self.subject.task.action}'
        return f'{where}, {words}' if words else where

    def _args(self) -> dict[str, object]:
        if not self.subject.task.refers:
            return dict(self.subject.task.args)
        return dict(resolve(self.subject.task.args, self.subject.state.scope(self.subject.key)))

    def _occupied(self) -> e.HoldRaised | None:
        """Hold a task that would place an item onto an occupied slot (semantics 3.2)."""
        section = self.subject.section
        if self.subject.task.qty_change != 1 or section is None:
            return None
        if self.subject.state.sections[section].slot is None:
            return None
        raised = e.HoldRaised(
            hold=self.subject.state.next_hold,
            **self.subject.key._asdict(),
            name=self.subject.task.name,
            component=self.subject.task.component,
            action=self.subject.task.action,
            reason=SLOT_OCCUPIED,
            answers=(RETRY,),  # other answers would leave a second item in the slot
        )
        return worded(self.subject.state, raised)


def _ended(progress: TaskState) -> str:
    """Say how a passed task ended."""
    if progress.end is None or progress.end is End.DONE:
        return 'done'
    why = progress.reason.value if progress.reason else progress.message
    return ': '.join(filter(None, (_ENDS[progress.end], why)))


_ENDS = {
    End.MARKED_DONE: 'marked done',
    End.SKIPPED: 'skipped',
    End.CONTINUED: 'failed and continued',
    End.REJECTED: 'failed and the item rejected',
    End.ABORTED: 'failed and the job aborted',
}
