"""Decorators that turn a failed attempt into one recorded decision (semantics 2.6, 2.7)."""

from __future__ import annotations

from py_trees.common import Status

from bt_orchestrator.base.errors import MissingResult
from bt_orchestrator.engine.tree.subject import Subject, Waiter
from bt_orchestrator.engine.tree.ticking import Ticked, Wrapper
from bt_orchestrator.model import events as e
from bt_orchestrator.model import failures
from bt_orchestrator.model.cell import OnFailure
from bt_orchestrator.model.goal import Reason
from bt_orchestrator.model.judging.results import found_words
from bt_orchestrator.model.script import Repeat
from bt_orchestrator.model.waits.starting import stopped_task


class Retry(Wrapper):
    """Repeats a failed attempt while retries are left."""

    def __init__(self, subject: Subject, child: Ticked) -> None:
        retries = subject.task.retries
        super().__init__(f'retry up to {retries} time{"s" if retries > 1 else ""}', child)
        self.subject = subject

    def update(self) -> Status:
        """Record another attempt, or let the failure pass."""
        self.feedback_message = ''
        if self.decorated.status is not Status.FAILURE:
            return self.decorated.status
        state, key, task = self.subject.state, self.subject.key, self.subject.task
        if not failures.may_retry(state, key, task):
            return Status.FAILURE
        not_before = self.subject.recorder.now + task.retry_delay_s
        attempt = state.tasks[key].attempt + 1
        retrying = e.TaskRetrying(
            **key._asdict(),
            attempt=attempt,
            not_before=not_before,
            uptime=self.subject.recorder.uptime,
        )
        self.subject.recorder.record([retrying])
        self.feedback_message = f'attempt {attempt}'
        return Status.RUNNING


class Verdict(Wrapper, Waiter):
    """Shows a task's verdict, and begins another round of its repeat (semantics 2.8, 3.9).

    The verdict was given when the end of the goal was recorded: a refused result is a failed
    attempt.
    """

    def __init__(self, subject: Subject, child: Ticked) -> None:
        assert subject.task.fails_unless is not None
        wanted = subject.with_bounds(subject.task.fails_unless)
        super().__init__(f'fails unless {wanted.words}', child)
        self.subject = subject

    def update(self) -> Status:
        """Begin a round if one is left, and nothing stops the section; else let it fail."""
        self.note(None)
        progress = self.subject.progress
        if progress is None or progress.reason is not Reason.RESULT_REFUSED:
            return self.decorated.status
        self.feedback_message = progress.message
        if self.decorated.status is not Status.FAILURE:
            return self.decorated.status
        state, key = self.subject.state, self.subject.key
        if not failures.may_repeat(state, key, self.subject.task):
            return Status.FAILURE
        stopped = stopped_task(state, key)
        if stopped is not None:
            self.note(stopped)
        else:
            self.subject.recorder.record([failures.begin_round(state, key)])
        return Status.RUNNING


class Conditional(Wrapper):
    """Shows the condition of a task, and the values that decided it (semantics 6.5)."""

    def __init__(self, subject: Subject, child: Ticked) -> None:
        assert subject.task.condition is not None
        self.condition = subject.with_bounds(subject.task.condition)
        super().__init__(str(self.condition), child)
        self.subject = subject

    def update(self) -> Status:
        """Show the values once the task has started or was skipped."""
        self.feedback_message = '' if self.subject.progress is None else self._found()
        return self.decorated.status

    def _found(self) -> str:
        try:
            words = found_words(self.condition, self.subject.state.scope(self.subject.key))
        except MissingResult as missing:
            return str(missing)
        return f'found {words}'


class Rounds(Wrapper):
    """Shows the rounds of a repeat; its verdicts begin them."""

    def __init__(self, subject: Subject, repeat: Repeat, child: Ticked) -> None:
        """Wrap the tasks of a repeat.

        :param subject: its first task
        """
        super().__init__(repeat.rounds, child)
        self.subject = subject
        self.repeat = repeat

    def update(self) -> Status:
        """Say which round it is, and why it began."""
        cycle = self.subject.cycle
        number = cycle.rounds.get(self.repeat.name, 0)
        why = cycle.round_causes.get(self.repeat.name, '')
        words = f'round {number + 1}' if number else ''
        self.feedback_message = ': '.join(filter(None, (words, why)))
        return self.decorated.status


_WORDS = {
    OnFailure.HOLD: 'hold if it fails',
    OnFailure.CONTINUE: 'continue if it fails',
    OnFailure.REJECT: 'reject if it fails',
    OnFailure.ABORT_JOB: 'abort the job if it fails',
}


class OnFailureDecorator(Wrapper):
    """Records the decision about a task that failed for good."""

    def __init__(self, subject: Subject, child: Ticked) -> None:
        super().__init__(_WORDS[subject.task.on_failure], child)
        self.subject = subject

    def update(self) -> Status:
        """Record the decision; the next tick shows its result."""
        self.feedback_message = ''
        if self.decorated.status is not Status.FAILURE:
            return self.decorated.status
        state, key = self.subject.state, self.subject.key
        self.subject.recorder.record(failures.decide(state, key, self.subject.task))
        self.feedback_message = 'decided'
        return Status.RUNNING
