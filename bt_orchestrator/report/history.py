"""What became of jobs: a second fold over the events, which forgets nothing that ended."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import OnFailure
from bt_orchestrator.model.jobs.job_record import RUNNING, FailureRecord, ItemRecord, JobRecord


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
