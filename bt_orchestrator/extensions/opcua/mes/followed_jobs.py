"""The listed jobs at every record of the journal, and each change of the state of one."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any

from bt_orchestrator.model import events as e
from bt_orchestrator.model.jobs.counting import MISSING, counts_of, good_of
from bt_orchestrator.model.jobs.isa95 import OVER, QUEUED, JobWord, queued_word, word_at_work
from bt_orchestrator.model.jobs.job_record import Counts
from bt_orchestrator.model.status import CellStatus, JobStatus, ListedJob
from bt_orchestrator.model.stop_reason import StopReason


@dataclass(frozen=True)
class News:
    """A job has another state or substate, at a record, or its order was changed."""

    job: ListedJob
    """As it is then."""
    before: JobWord | None
    """Its state before; None: it is new."""
    seq: int
    time: float
    interrupted: str = ''
    """Why the line stands still, in words; empty: it does not."""
    remark: str = ''
    """The event of the job, where its state stays."""


@dataclass
class _Entry:
    """A listed job, and what a status does not tell of it."""

    job: ListedJob
    is_paused: bool = False
    """An operator paused it, as far as the facts show."""
    nonconforming: set[str] = field(default_factory=set)
    """Its items that are."""

    @property
    def is_at_work(self) -> bool:
        """Tell whether it is on the line: what stops the line interrupts it."""
        return self.job.status.started_at is not None and self.job.status.state not in OVER

    def set(self, **values: Any) -> None:
        """Change fields of its status."""
        self.job = replace(self.job, status=replace(self.job.status, **values))

    def count(self, name: str) -> None:
        """Count one more."""
        self.set(**{name: getattr(self.job.status, name) + 1})

    def count_good(self) -> None:
        """Derive the good ones from the other counts."""
        self.set(good=good_of(self.job.status.packed, self.job.status.nonconforming))


class FollowedJobs:
    """Begins with the jobs that a cell lists, then follows its events.

    A status leaves out states that last for a moment; the events have them all.
    """

    def __init__(self) -> None:
        self._entries: dict[str, _Entry] = {}
        self._stop_reason: StopReason | None = None
        self._stop_message = ''
        self.seq = 0
        """The last event that is contained."""

    def begin(self, status: CellStatus | None = None, listed: Iterable[ListedJob] = ()) -> None:
        """Begin anew.

        :param status: events up to it are known; None: nothing is
        :param listed: what is told of jobs beside it
        """
        self._entries = {job.status.id: _Entry(job) for job in listed}
        self._stop_reason, self._stop_message, self.seq = None, '', 0
        if status is not None:
            self.seq = status.seq
            self.agree(status)

    def agree(self, status: CellStatus) -> None:
        """Take over what a status says of its jobs, if it is of the last event that was heard."""
        if status.seq != self.seq:
            return
        self._stop_reason, self._stop_message = status.stop_reason, status.stop_message
        for job in status.jobs:
            entry = self._entries.setdefault(job.id, _Entry(ListedJob(job)))
            entry.job = replace(entry.job, status=job)
            if status.stop_reason is None and job.state is JobWord.SUSPENDED:
                entry.is_paused = True

    def take(self, listed: Iterable[ListedJob]) -> None:
        """Take in parameters, details and reasons of all jobs; states are known better here.

        A job that ended and is not among them was cleared.
        """
        jobs = {job.status.id: job for job in listed}
        for name, job in jobs.items():
            entry = self._entries.setdefault(name, _Entry(job))
            entry.job = replace(job, status=entry.job.status)
        for job in self.ended():
            if job.status.id not in jobs:
                del self._entries[job.status.id]

    def get(self, job: str) -> ListedJob | None:
        """Return a job; None: it is not listed, as far as is known here."""
        entry = self._entries.get(job)
        return None if entry is None else entry.job

    def ended(self) -> list[ListedJob]:
        """Return the jobs that ended and were not cleared, in the order in which they ended."""
        return [entry.job for entry in self._entries.values() if entry.job.status.state in OVER]

    @property
    def interrupted(self) -> str:
        """Why the line stands still, in words; empty: it does not."""
        return self._stop_message if self._stop_reason is not None else ''

    def follow(self, event: e.Event) -> list[News]:
        """Take in the next event; return the changes of state."""
        if event.seq <= self.seq:
            return []
        self.seq = event.seq
        if isinstance(event, e.StopReasonChanged):
            known = {reason.value: reason for reason in StopReason}
            self._stop_reason = known.get(event.stop_reason)
            self._stop_message = event.reason
            at_work = [entry for entry in self._entries.values() if entry.is_at_work]
            return list(self._news(event, [(entry, entry.job.status.state) for entry in at_work]))
        entry, before = self._concerned(event)
        if isinstance(event, (e.ComponentOutOfService, e.ComponentInService)):
            return list(self._news(event, list(self._of_service(event))))
        if isinstance(event, e.ScriptReleased):
            return list(self._news(event, list(self._of_release(event))))
        if isinstance(event, (e.JobRemoved, e.JobCleared)):
            self._entries.pop(event.job, None)
            return []
        return list(self._news(event, [(entry, before)])) if entry is not None else []

    def _concerned(self, event: e.Event) -> tuple[_Entry | None, JobWord | None]:
        """Return the job that an event has changed, and its state before."""
        if isinstance(event, e.JobQueued):
            entry = self._entries[event.job] = _Entry(_ordered(event))
            return entry, None
        fold = _FOLDS.get(type(event))
        known = self._entries.get(getattr(event, 'job', None) or '')
        if fold is None or known is None:
            return None, None
        before = known.job.status.state
        fold(known, event)
        if isinstance(event, _ENDS):
            self._entries[event.job] = self._entries.pop(event.job)  # the last that ended
        return known, before

    def _of_service(
        self, event: e.ComponentOutOfService | e.ComponentInService
    ) -> Iterator[tuple[_Entry, JobWord]]:
        """Note which components the jobs of the queue lack; yield these, and their states before.

        Those on the line are left to the next status.
        """
        is_out = isinstance(event, e.ComponentOutOfService)
        concerned = event.jobs if isinstance(event, e.ComponentOutOfService) else self._entries
        for name in concerned:
            entry = self._entries.get(name)
            if entry is None or entry.job.status.state not in QUEUED:
                continue
            before, lacks = entry.job.status.state, entry.job.status.unavailable
            left = tuple(component for component in lacks if component != event.component)
            _queued(entry, unavailable=(*left, event.component) if is_out else left)
            yield entry, before

    def _of_release(self, event: e.ScriptReleased) -> Iterator[tuple[_Entry, JobWord]]:
        """Note which jobs do not wait for the release any more, and their states before."""
        for entry in self._entries.values():
            if entry.job.status.unreleased == event.digest:
                before = entry.job.status.state
                _queued(entry, awaits_release=False)
                yield entry, before

    def _news(
        self, event: e.Event, changed: Iterable[tuple[_Entry, JobWord | None]]
    ) -> Iterator[News]:
        for entry, before in changed:
            entry.set(state=self._word(entry))
            remark = _REMARKS.get(type(event), '')
            if entry.job.status.state is not before or remark:
                yield News(entry.job, before, event.seq, event.time, self.interrupted, remark)

    def _word(self, entry: _Entry) -> JobWord:
        """Derive the state of a job on the line; that of another is as the events said."""
        if not entry.is_at_work:
            return entry.job.status.state
        return word_at_work(self._stop_reason, is_paused=entry.is_paused)


_TERMS = (
    *('digest', 'recipe', 'recipe_version', 'quantity', 'priority', 'start', 'due'),
    *('awaits_start', 'awaits_release', 'unavailable', 'anew'),
)


def _ordered(event: e.JobQueued) -> ListedJob:
    status = JobStatus(
        event.job,
        event.script,
        queued_word(event),
        queued_at=event.time,
        position=event.position or 0,
        held=event.held,
        rest_of=event.rest_of,
        by_recipe=event.choice is not None,
        **_terms(event),
    )
    return ListedJob(status, event.params, event.details, choice=event.choice)


def _terms(event: e.OrderEvent) -> dict[str, Any]:
    return {name: getattr(event, name) for name in _TERMS}


def _updated(entry: _Entry, event: e.JobUpdated) -> None:
    _queued(entry, script=event.script, by_recipe=event.choice is not None, **_terms(event))
    entry.job = replace(entry.job, params=event.params, details=event.details, choice=event.choice)


def _queued(entry: _Entry, **values: Any) -> None:
    """Change fields of a job in the queue, whose state follows from them."""
    entry.set(**values)
    entry.set(state=queued_word(entry.job.status))


def _held(entry: _Entry, _: e.JobHeld) -> None:
    _queued(entry, held=True)


def _released(entry: _Entry, _: e.JobReleased) -> None:
    _queued(entry, held=False)


def _may_start(entry: _Entry, _: e.JobMayStart) -> None:
    entry.set(awaits_start=False)


def _started(entry: _Entry, event: e.JobStarted) -> None:
    entry.set(state=JobWord.RUNNING, started_at=event.time, position=0, held=False)


def _paused(entry: _Entry, event: e.JobPaused | e.JobResumed) -> None:
    entry.is_paused = isinstance(event, e.JobPaused)


def _ending(entry: _Entry, event: e.JobStopping | e.JobAborting) -> None:
    entry.is_paused = False
    entry.job = replace(entry.job, reason=event.reason)
    ending = 'stopping' if isinstance(event, e.JobStopping) else 'aborting'
    entry.set(ending=ending, held=False, awaits_start=False, awaits_release=False, unavailable=())


def _ended(entry: _Entry, event: e.JobCompleted | e.JobAborted) -> None:
    entry.job = replace(entry.job, reason=event.reason or entry.job.reason)
    entry.set(
        state=JobWord.ABORTED if isinstance(event, e.JobAborted) else JobWord.ENDED,
        ended_at=event.time,
        ending='',
        position=0,
        expected_end_s=None,
        **{_COUNTED[name]: count for name, count in event.counts.items() if name in _COUNTED},
    )
    entry.count_good()


def _cycle_started(entry: _Entry, event: e.CycleStarted) -> None:
    number = event.item.rpartition('/')[2]
    if number.isdecimal() and int(number) > entry.job.status.started:
        entry.set(started=int(number))


def _placed(entry: _Entry, _: e.ItemPlaced) -> None:
    entry.count('placed')


def _missing(entry: _Entry, _: e.ItemMissing) -> None:
    entry.count(MISSING)


def _removed(entry: _Entry, event: e.ItemRemoved) -> None:
    for name in counts_of(event.how, is_nonconforming=event.item in entry.nonconforming):
        entry.count(name)
    entry.count_good()


def _continued(entry: _Entry, event: e.TaskContinued) -> None:
    if event.nonconforming is not None:
        _nonconforming(entry, event)


def _nonconforming(entry: _Entry, event: e.ItemNonconforming | e.TaskContinued) -> None:
    assert event.item is not None
    entry.nonconforming.add(event.item)


_REMARKS: Mapping[type[e.Event], str] = {
    e.JobUpdated: 'was changed',
    e.JobMayStart: 'no longer waits for its start',
}

_ENDS = (e.JobCompleted, e.JobAborted)

_COUNTED = {
    **{counter.name: counter.name for counter in fields(Counts)},
    'removed': 'by_hand',
}

_FOLDS: Mapping[type[e.Event], Callable[[_Entry, Any], None]] = {
    e.JobUpdated: _updated,
    e.JobHeld: _held,
    e.JobReleased: _released,
    e.JobMayStart: _may_start,
    e.JobStarted: _started,
    e.JobPaused: _paused,
    e.JobResumed: _paused,
    e.JobStopping: _ending,
    e.JobAborting: _ending,
    e.JobCompleted: _ended,
    e.JobAborted: _ended,
    e.CycleStarted: _cycle_started,
    e.ItemPlaced: _placed,
    e.ItemMissing: _missing,
    e.ItemRemoved: _removed,
    e.ItemNonconforming: _nonconforming,
    e.TaskContinued: _continued,
}
