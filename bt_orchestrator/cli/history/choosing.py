"""The jobs and items of a journal that the options of the verb `history` choose."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import replace

from bt_orchestrator.model.jobs.job_record import ItemRecord, JobRecord
from bt_orchestrator.view.report.reading import Reading


def jobs_meant(reading: Reading, args: argparse.Namespace) -> list[JobRecord]:
    """Read the jobs that may be meant; for items that are named, theirs alone."""
    names = {one.rpartition('/')[0] for one in args.item or ()}
    job = args.job or (names.pop() if len(names) == 1 else None)
    return [one for one in reading.jobs(job).jobs.values() if _is_wanted(one, args)]


def with_items(jobs: Sequence[JobRecord], args: argparse.Namespace) -> Iterator[JobRecord]:
    """Yield the jobs that have the items chosen, with these items only."""
    for job in jobs:
        items = {name: item for name, item in job.items.items() if _is_meant(item, args)}
        if items:
            failures = [one for one in job.failures if one.item in items]
            yield replace(job, items=items, failures=failures)


def _is_meant(item: ItemRecord, args: argparse.Namespace) -> bool:
    is_lot = args.lot is None or item.lots.get(args.lot[0]) == args.lot[1]
    is_named = args.item is None or item.item in args.item
    return is_lot and is_named and args.serial in (None, item.serial)


def _is_wanted(job: JobRecord, args: argparse.Namespace) -> bool:
    return (
        args.job in (None, job.job)
        and (args.since is None or job.queued >= args.since)
        and (args.until is None or job.queued <= args.until)
    )


def no_job(args: argparse.Namespace) -> str:
    """Say that a journal knows nothing of the job that is named."""
    known = f'bt-orchestrator history --journal {args.journal}'
    return f'the journal {args.journal} knows no job {args.job}; {known} lists those it has'


def no_item(args: argparse.Namespace) -> str:
    """Say that a journal does not have the chosen items."""
    if not args.item:
        return f'the journal {args.journal} has no such item any more'
    named = ' and no '.join(args.item)
    return (
        f'the journal {args.journal} knows no item {named}: it never was, or its events are not '
        'kept any more; history --job JOB --items names the items of a job'
    )
