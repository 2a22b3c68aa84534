"""Records of jobs as text for a person."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from datetime import datetime

from bt_orchestrator.model.hold_words import why_words
from bt_orchestrator.model.jobs.job_record import JobRecord
from bt_orchestrator.model.status_words import script_words
from bt_orchestrator.view.report.exports import shown
from bt_orchestrator.view.report.tables import table

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
