"""What became of jobs: a second fold over the events, which forgets nothing that ended."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import OnFailure
from bt_orchestrator.model.codec import from_plain, to_plain
from bt_orchestrator.model.state import JobState

QUEUED, RUNNING, COMPLETED, ABORTED = 'queued', 'running', 'completed', 'aborted'
"""How a job stands or ended."""


@dataclass(frozen=True)
class Counts:
    """Counts of one job (semantics 6.2)."""

    started: int = 0
    placed: int = 0
    packed: int = 0
    rejected: int = 0
    missing: int = 0
    nonconforming: int = 0


@dataclass(frozen=True)
class FailureRecord:
    """One attempt that failed."""

    time: float
    task: str
    attempt: int
    reason: str
    message: str = ''
    section: int | None = None
    item: str | None = None


@dataclass
class ItemRecord:
    """One item, from its source cycle to its end."""

    item: str
    started: float
    ended: float | None = None
    how: str = ''
    """packed, rejected, by_hand or missing; empty while it is on the line."""
    nonconforming: list[str] = field(default_factory=list)
    results: dict[str, Mapping[str, Any]] = field(default_factory=dict)


@dataclass
class JobRecord:
    """One job, from its order to its end."""

    job: str
    script: str
    quantity: int
    queued: float
    params: Mapping[str, Any] = field(default_factory=dict)
    started: float | None = None
    ended: float | None = None
    status: str = QUEUED
    counts: Counts = Counts()
    items: dict[str, ItemRecord] = field(default_factory=dict)
    failures: list[FailureRecord] = field(default_factory=list)
    complete: bool = True
    """False: its events were removed, and with them its items and failures."""


def record_of(job: JobState) -> JobRecord:
    """Return what stays of a job that ended when its events are gone."""
    names = [one.name for one in dataclasses.fields(Counts)]
    return JobRecord(
        job=job.job.id,
        script=job.job.script.name,
        quantity=job.job.quantity,
        queued=job.queued_at,
        params=job.job.params,
        started=job.started_at,
        ended=job.ended_at,
        status=ABORTED if job.aborting else COMPLETED,
        counts=Counts(**{name: getattr(job.progress, name) for name in names}),
        complete=False,
    )


def job_to_plain(job: JobRecord) -> dict[str, Any]:
    """Return a job as JSON carries it."""
    plain: dict[str, Any] = to_plain(job)
    return plain


def job_from_plain(plain: Mapping[str, Any]) -> JobRecord:
    """Return the job that a record tells of."""
    return from_plain(JobRecord, plain)


class History:
    """Jobs as the records of the journal tell of them; lets pass what it does not know."""

    def __init__(self, known: Iterable[JobRecord] = ()) -> None:
        """Begin.

        :param known: what is kept of jobs; records that tell all of one take its place
        """
        self.jobs: dict[str, JobRecord] = {job.job: job for job in known}
        """By id, in the order in which they were queued."""

    def follow(self, record: Mapping[str, Any]) -> None:
        """Take in one record (formats: events)."""
        fold = _FOLDS.get(record['event'])
        if record['event'] == e.JobQueued.event:
            self._begin(record)
        elif fold is not None and record.get('job') in self.jobs:
            job = self.jobs[record['job']]
            if job.complete:
                fold(job, record)

    def _begin(self, record: Mapping[str, Any]) -> None:
        self.jobs.pop(record['job'], None)
        self.jobs[record['job']] = JobRecord(
            job=record['job'],
            script=record['script'],
            quantity=record['quantity'],
            queued=record['time'],
            params=record.get('params', {}),
        )


_Record = Mapping[str, Any]


def _count(job: JobRecord, name: str) -> None:
    job.counts = dataclasses.replace(job.counts, **{name: getattr(job.counts, name) + 1})


def _job_started(job: JobRecord, record: _Record) -> None:
    job.started, job.status = record['time'], RUNNING


def _job_updated(job: JobRecord, record: _Record) -> None:
    job.script, job.quantity = record['script'], record['quantity']
    job.params = record.get('params', {})


def _job_ended(job: JobRecord, record: _Record) -> None:
    job.ended = record['time']
    job.status = record.get('exit_status', record['event'].partition('.')[2])


def _cycle_started(job: JobRecord, record: _Record) -> None:
    if record['item'] not in job.items:
        job.items[record['item']] = ItemRecord(record['item'], record['time'])
        _count(job, 'started')


def _item_placed(job: JobRecord, _: _Record) -> None:
    _count(job, 'placed')


def _item_missing(job: JobRecord, record: _Record) -> None:
    _count(job, 'missing')
    _end_item(job, record, 'missing')


def _item_removed(job: JobRecord, record: _Record) -> None:
    how = record['how']
    _count(job, 'missing' if how == 'by_hand' else how)
    _end_item(job, record, how)


def _item_of(job: JobRecord, record: _Record) -> ItemRecord:
    """Return the item that a record is about, also if the one that began it cannot be read."""
    name = record['item']
    return job.items.setdefault(name, ItemRecord(name, record['time']))


def _end_item(job: JobRecord, record: _Record, how: str) -> None:
    item = _item_of(job, record)
    item.ended, item.how = record['time'], how


def _task_succeeded(job: JobRecord, record: _Record) -> None:
    if 'item' in record and record.get('results'):
        _item_of(job, record).results[record['task']] = record['results']


def _task_failed(job: JobRecord, record: _Record) -> None:
    names = [one.name for one in dataclasses.fields(FailureRecord)]
    job.failures.append(FailureRecord(**{n: record[n] for n in names if n in record}))


def _task_continued(job: JobRecord, record: _Record) -> None:
    if 'item' not in record or record['policy'] != OnFailure.CONTINUE.value:
        return
    item = _item_of(job, record)
    if not item.nonconforming:
        _count(job, 'nonconforming')
    item.nonconforming.append(record['task'])


_FOLDS: Mapping[str, Callable[[JobRecord, _Record], None]] = {
    'job.started': _job_started,
    'job.updated': _job_updated,
    'job.completed': _job_ended,
    'job.aborted': _job_ended,
    'job.removed': _job_ended,
    'cycle.started': _cycle_started,
    'item.placed': _item_placed,
    'item.missing': _item_missing,
    'item.removed': _item_removed,
    'task.succeeded': _task_succeeded,
    'task.marked_done': _task_succeeded,
    'task.failed': _task_failed,
    'task.continued': _task_continued,
}

FOLLOWED = (e.JobQueued.event, *_FOLDS)
"""The events that tell of jobs; others need not be read."""
