"""The verb `history`: which jobs a journal knows, and what became of them."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from contextlib import closing
from pathlib import Path

from bt_orchestrator.cli.journal_file import open_records, say_damage
from bt_orchestrator.cli.moments import add_period_options
from bt_orchestrator.mes.job_response import b2mml, response_of_record
from bt_orchestrator.model.codec import json_of
from bt_orchestrator.model.jobs.job_record import JobRecord, job_to_plain
from bt_orchestrator.report.job_text import job_text
from bt_orchestrator.report.reading import Reading

DESCRIPTION = """\
Print the jobs of a journal, oldest first: when they ran, how they ended, how many items became
what, and why attempts failed. The journal is only read; its node may run or not."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    parser.add_argument('--journal', type=Path, required=True, metavar='FILE', help='the journal')
    parser.add_argument('--job', metavar='JOB', help='this job only')
    parser.add_argument('--items', action='store_true', help='also every item, with its results')
    as_json = parser.add_mutually_exclusive_group()
    as_json.add_argument('--json', action='store_true', help='one JSON object a job and line')
    as_json.add_argument(
        '--b2mml',
        action='store_true',
        help='the same as job responses for an MES, with the names of B2MML; jobs that have '
        'started',
    )
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
    for line in _lines(jobs, args):
        print(line)
    return 1 if reading.lost else 0


def _is_wanted(job: JobRecord, args: argparse.Namespace) -> bool:
    return (
        args.job in (None, job.job)
        and (args.since is None or job.queued >= args.since)
        and (args.until is None or job.queued <= args.until)
    )


def _lines(jobs: Sequence[JobRecord], args: argparse.Namespace) -> Iterator[str]:
    if args.b2mml:
        responses = map(response_of_record, jobs)
        return (json_of(b2mml(one)) for one in responses if one is not None)
    return _json(jobs, args) if args.json else job_text(jobs, with_items=args.items)


def _json(jobs: Sequence[JobRecord], args: argparse.Namespace) -> Iterator[str]:
    for job in jobs:
        plain = job_to_plain(job)
        plain.setdefault('status', job.status)
        plain['counts'] = vars(job.counts)
        if not args.items:
            plain.pop('items', None)
        yield json_of(plain)
