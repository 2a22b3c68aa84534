"""The fold from events to the records of jobs and items (ISA-95: job responses).

The state of the cell forgets what left the line. This fold keeps it: the items of a job, how each
ended, and which attempts failed.
"""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from datetime import datetime
from typing import Any

from bt_orchestrator.model import events as e
from bt_orchestrator.model.hold_words import why_words
from bt_orchestrator.model.jobs.counting import (
    APPROVED,
    GOOD,
    MISSING,
    PIECE_REFUSED,
    PIECE_WAITS,
    counts_of,
    kind_of,
)
from bt_orchestrator.model.jobs.job_folds import terms_of
from bt_orchestrator.model.jobs.job_record import (
    REMOVED,
    RUNNING,
    FailureRecord,
    ItemRecord,
    JobRecord,
)
from bt_orchestrator.model.status_words import script_words
from bt_orchestrator.view.report.tables import shown, table


class JobFold:
    """Takes in one event after another, from the `job.queued` of a job on."""

    def __init__(self, known: Iterable[JobRecord] = ()) -> None:
        """Begin.

        :param known: summaries of jobs; complete events of a job replace its summary
        """
        self.jobs: dict[str, JobRecord] = {job.job: job for job in known}
        """By id, in the order in which they were queued."""

    def follow(self, event: e.Event) -> None:
        """Take in the next event; one of a job whose beginning was not seen changes nothing."""
        if isinstance(event, e.JobQueued):
            self._begin(event)
            return
        fold = _FOLDS.get(type(event))
        job = self.jobs.get(getattr(event, 'job', None) or '')
        if fold is not None and job is not None and job.complete:
            fold(job, event)

    def _begin(self, event: e.JobQueued) -> None:
        self.jobs.pop(event.job, None)
        self.jobs[event.job] = JobRecord(
            job=event.job,
            script=event.script,
            quantity=event.quantity,
            queued=event.time,
            digest=event.digest,
            recipe=event.recipe,
            recipe_version=event.recipe_version,
            rest_of=event.rest_of,
            params=event.params,
            terms=terms_of(event),
        )


def _count(job: JobRecord, name: str) -> None:
    job.counts = dataclasses.replace(job.counts, **{name: getattr(job.counts, name) + 1})


def _started(job: JobRecord, event: e.JobStarted) -> None:
    job.started, job.status = event.time, RUNNING


def _updated(job: JobRecord, event: e.JobUpdated) -> None:
    job.script, job.quantity, job.params = event.script, event.quantity, event.params
    job.digest, job.recipe, job.recipe_version = event.digest, event.recipe, event.recipe_version
    job.terms = terms_of(event)


def _piece_waits(job: JobRecord, event: e.JobPaused) -> None:
    if event.item is not None:
        job.first_piece, job.first_piece_state = event.item, PIECE_WAITS


def _piece_decided(job: JobRecord, event: e.JobResumed | e.JobStopping) -> None:
    if event.item is not None:
        is_refused = isinstance(event, e.JobStopping) or event.another
        job.first_piece_state = PIECE_REFUSED if is_refused else APPROVED


def _ended(job: JobRecord, event: e.JobCompleted | e.JobAborted) -> None:
    job.ended, job.reason = event.time, event.reason
    job.status = event.exit_status or event.event.partition('.')[2]


def _removed(job: JobRecord, event: e.JobRemoved) -> None:
    job.ended, job.status = event.time, REMOVED


def _cycle_started(job: JobRecord, event: e.CycleStarted) -> None:
    if event.item not in job.items:
        job.items[event.item] = ItemRecord(event.item, event.time)
        _count(job, 'started')


def _item_placed(job: JobRecord, event: e.ItemPlaced) -> None:
    _count(job, 'placed')
    _item_of(job, event.item, event.time).lots = event.lots


def _item_identified(job: JobRecord, event: e.ItemIdentified) -> None:
    _item_of(job, event.item, event.time).serial = event.serial


def _item_missing(job: JobRecord, event: e.ItemMissing) -> None:
    _count(job, 'missing')
    _end_item(job, event, MISSING)


def _item_removed(job: JobRecord, event: e.ItemRemoved) -> None:
    is_marked = bool(_item_of(job, event.item, event.time).nonconforming)
    for name in counts_of(event.how, is_nonconforming=is_marked):
        _count(job, name)
    item = _end_item(job, event, event.how)
    item.good = kind_of(event.how, is_nonconforming=is_marked) == GOOD


def _end_item(job: JobRecord, event: e.ItemEvent, how: str) -> ItemRecord:
    item = _item_of(job, event.item, event.time)
    item.ended, item.how = event.time, how
    return item


def _item_of(job: JobRecord, name: str, time: float) -> ItemRecord:
    """Return the record of an item, also if the event that began it cannot be read."""
    return job.items.setdefault(name, ItemRecord(name, time))


def _task_done(job: JobRecord, event: e.TaskSucceeded | e.TaskMarkedDone) -> None:
    if event.item is not None and event.results:
        _item_of(job, event.item, event.time).results[event.task] = event.results


def _task_failed(job: JobRecord, event: e.TaskFailed) -> None:
    names = [field.name for field in dataclasses.fields(FailureRecord)]
    job.failures.append(FailureRecord(**{name: getattr(event, name) for name in names}))


def _task_continued(job: JobRecord, event: e.TaskContinued) -> None:
    if event.nonconforming is None:
        return
    item = _nonconforming(job, event)
    refused = (f.results for f in reversed(job.failures) if f.is_of(item.item, event.task))
    results = next(refused, None)
    if results:
        item.results[event.task] = results


def _round_begun(job: JobRecord, event: e.RoundBegun) -> None:
    item = _item_of(job, event.item, event.time)
    item.rounds[event.repeat] = item.rounds.get(event.repeat, 0) + 1
    for task in event.tasks:
        item.results.pop(task, None)


def _nonconforming(job: JobRecord, event: e.ItemNonconforming | e.TaskContinued) -> ItemRecord:
    assert event.item is not None
    item = _item_of(job, event.item, event.time)
    item.nonconforming.append(event.task)
    return item


_FOLDS: Mapping[type[e.Event], Callable[[JobRecord, Any], object]] = {
    e.JobStarted: _started,
    e.JobUpdated: _updated,
    e.JobPaused: _piece_waits,
    e.JobResumed: _piece_decided,
    e.JobStopping: _piece_decided,
    e.JobCompleted: _ended,
    e.JobAborted: _ended,
    e.JobRemoved: _removed,
    e.CycleStarted: _cycle_started,
    e.ItemPlaced: _item_placed,
    e.ItemIdentified: _item_identified,
    e.ItemMissing: _item_missing,
    e.ItemRemoved: _item_removed,
    e.TaskSucceeded: _task_done,
    e.TaskMarkedDone: _task_done,
    e.TaskFailed: _task_failed,
    e.TaskContinued: _task_continued,
    e.ItemNonconforming: _nonconforming,
    e.RoundBegun: _round_begun,
}

FOLLOWED = (e.JobQueued.event, *(kind.event for kind in _FOLDS))
"""Names of the events that change a record; others need not be read."""


# Records of jobs as text for a person.

_HEADERS = ('job', 'script', 'status', 'started', 'ended', 'items', 'packed', 'rejected')
_HEADERS_BAD = ('missing', 'nonconforming', 'failed attempts')


def job_text(jobs: Sequence[JobRecord], *, with_items: bool) -> Iterator[str]:
    """Yield a table of jobs, and below it what failed, or with items all that is known."""
    yield from table((*_HEADERS, *_HEADERS_BAD), [_row(job) for job in jobs])
    for job in jobs:
        yield from _items(job) if with_items else _failures(job, f'{job.job}: ')


def _row(job: JobRecord) -> tuple[str, ...]:
    counts = job.counts
    numbers = (counts.packed, counts.rejected, counts.missing, counts.nonconforming)
    failed = str(len(job.failures)) if job.complete else '?'
    named = (job.job, script_words(job), job.status, _when(job.started), _when(job.ended))
    return (*named, str(job.quantity), *map(str, numbers), failed)


def _failures(job: JobRecord, begin: str) -> Iterator[str]:
    for (task, reason), number in Counter((f.task, f.reason) for f in job.failures).items():
        times = f'{number} times ' if number > 1 else ''
        yield f'{begin}{task} failed {times}({reason})'


def _items(job: JobRecord) -> Iterator[str]:
    yield ''
    if not job.complete:
        yield f'{job.job}: its events were removed, and its items with them'
        return
    yield f'{job.job}:'
    yield from _failures(job, '  ')
    for item in job.items.values():
        when = f'  {_when(item.ended)}' if item.ended else ''
        yield f'  {item.item}  {item.how or "on the line"}{when}'
        if item.serial:
            yield f'    serial: {item.serial}'
        if item.lots:
            yield f'    lots: {shown(item.lots)}'
        for task, results in item.results.items():
            yield f'    {task}: {shown(results)}'
        for task, number in item.rounds.items():
            yield f'    {task}: {number} more round{"s" if number > 1 else ""}'
        for failure in job.failures:
            if failure.item == item.item:
                why = why_words(failure.reason, failure.message, failure.controller_said)
                yield f'    {failure.task} failed: {why}'
        if item.nonconforming:
            yield f'    nonconforming: {", ".join(item.nonconforming)}'


def _when(time: float | None) -> str:
    if time is None:
        return '-'
    return datetime.fromtimestamp(time).isoformat(' ', timespec='seconds')
