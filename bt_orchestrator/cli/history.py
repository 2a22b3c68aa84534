"""The verb `history`: which jobs a journal knows, and what became of them."""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import closing
from datetime import datetime
from pathlib import Path

from bt_orchestrator.cli.journal_file import open_records
from bt_orchestrator.cli.journal_output import say_damage, shown
from bt_orchestrator.cli.moments import add_period_options
from bt_orchestrator.cli.tables import table
from bt_orchestrator.model.codec import json_of
from bt_orchestrator.model.jobs.job_record import JobRecord, job_to_plain
from bt_orchestrator.report.reading import Reading

DESCRIPTION = """\
Print the jobs of a journal, oldest first: when they ran, how they ended, how many items became
what, and why attempts failed. The journal is only read; its node may run or not."""

_HEADERS = ('job', 'script', 'status', 'started', 'ended', 'items', 'packed', 'rejected')
_HEADERS_BAD = ('missing', 'nonconforming', 'failed attempts')


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    parser.add_argument('--journal', type=Path, required=True, metavar='FILE', help='the journal')
    parser.add_argument('--job', metavar='JOB', help='this job only')
    parser.add_argument('--items', action='store_true', help='also every item, with its results')
    parser.add_argument('--json', action='store_true', help='one JSON object a job and line')
    add_period_options(parser, 'jobs queued')


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns 1 if a job is not there, or a record is damaged."""
    with closing(open_records(args.journal)) as records:
        reading = Reading(records, say_damage)
        fold = reading.jobs(args.job)
    jobs = [job for job in fold.jobs.values() if _is_wanted(job, args)]
    if args.job is not None and not jobs:
        print(f'the journal {args.journal} knows no job {args.job}', file=sys.stderr)
        return 1
    for line in _json(jobs, args) if args.json else _text(jobs, args):
        print(line)
    return 1 if reading.lost else 0


def _is_wanted(job: JobRecord, args: argparse.Namespace) -> bool:
    return (
        args.job in (None, job.job)
        and (args.since is None or job.queued >= args.since)
        and (args.until is None or job.queued <= args.until)
    )


def _json(jobs: Sequence[JobRecord], args: argparse.Namespace) -> Iterator[str]:
    for job in jobs:
        plain = job_to_plain(job)
        plain.setdefault('status', job.status)
        plain['counts'] = vars(job.counts)
        if not args.items:
            plain.pop('items', None)
        yield json_of(plain)


def _text(jobs: Sequence[JobRecord], args: argparse.Namespace) -> Iterator[str]:
    yield from table((*_HEADERS, *_HEADERS_BAD), [_row(job) for job in jobs])
    for job in jobs:
        yield from _items(job) if args.items else _failures(job, f'{job.job}: ')


def _row(job: JobRecord) -> tuple[str, ...]:
    counts = job.counts
    numbers = (counts.packed, counts.rejected, counts.missing, counts.nonconforming)
    failed = str(len(job.failures)) if job.complete else '?'
    named = (job.job, job.script, job.status, _when(job.started), _when(job.ended))
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
        for task, results in item.results.items():
            yield f'    {task}: {shown(results)}'
        for failure in job.failures:
            if failure.item == item.item:
                yield f'    {failure.task} failed: {failure.reason}'
        if item.nonconforming:
            yield f'    nonconforming: {", ".join(item.nonconforming)}'


def _when(time: float | None) -> str:
    if time is None:
        return '-'
    return datetime.fromtimestamp(time).isoformat(' ', timespec='seconds')
