"""The verb `history`: which jobs and items a journal knows, and what became of them."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from contextlib import closing

from bt_orchestrator.cli.history.chart import chart_svg
from bt_orchestrator.cli.history.choosing import jobs_meant, no_item, no_job, with_items
from bt_orchestrator.cli.history.forecast import forecast_text
from bt_orchestrator.cli.history.item_records import (
    as_html,
    as_json,
    histories,
    refuse_too_many,
)
from bt_orchestrator.cli.history.options import (
    add_arguments,
    chooses_items,
    is_record,
    refuse_contradictions,
)
from bt_orchestrator.cli.history.script_of_job import script_of
from bt_orchestrator.cli.journal_file import open_records, say_damage
from bt_orchestrator.cli.output import opened
from bt_orchestrator.model.codec import json_of
from bt_orchestrator.model.jobs.job_record import JobRecord, all_counts, job_to_plain
from bt_orchestrator.view.report.isa95.job_response import b2mml, response_of_record
from bt_orchestrator.view.report.job_text import job_text
from bt_orchestrator.view.report.reading import Reading

__all__ = ['add_arguments', 'run']


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns 1 if a job is not there, or a record is damaged."""
    refuse_contradictions(args)
    lacks: list[str] = []

    def say(sentence: str) -> None:
        lacks.append(sentence)
        say_damage(sentence)

    with closing(open_records(args.journal)) as records:
        reading = Reading(records, say)
        text = _text(reading, args, lacks)
        if text is None:
            return 1
        with opened(args.output) as file:
            file.write(text)
    return 1 if reading.lost else 0


def _text(reading: Reading, args: argparse.Namespace, lacks: Sequence[str]) -> str | None:
    """Return the output; None: there is no output, and the user has read why."""
    if args.forecast:
        return forecast_text(reading, args)
    if args.gantt:
        return chart_svg(reading, args)
    jobs = jobs_meant(reading, args)
    if args.job is not None and not jobs:
        print(no_job(args), file=sys.stderr)
        return None
    if chooses_items(args):
        args.items, jobs = True, list(with_items(jobs, args))
        if not jobs:
            print(no_item(args), file=sys.stderr)
            return None
    return _records(jobs, reading, args, lacks) if is_record(args) else _table(jobs, reading, args)


def _table(jobs: Sequence[JobRecord], reading: Reading, args: argparse.Namespace) -> str:
    lines = script_of(jobs[0], reading, args.journal) if args.script else _lines(jobs, args)
    return ''.join(f'{line}\n' for line in lines)


def _records(
    jobs: Sequence[JobRecord], reading: Reading, args: argparse.Namespace, lacks: Sequence[str]
) -> str:
    """Return the whole records of items.

    :raises NoItem: the journal has one of them no more
    :raises WrongUse: they are too many for a document
    """
    names = [name for job in jobs for name in job.items]
    if args.html:
        refuse_too_many(names)
    items = histories(reading, args.journal, names)
    if args.record:
        return as_json(items)
    return as_html(items, args.journal, _title(args, names), lacks)


def _title(args: argparse.Namespace, names: Sequence[str]) -> str:
    if len(names) == 1:
        return f'Item {names[0]}'
    chosen = [f'serial {args.serial}'] if args.serial else []
    chosen += [f'lot {args.lot[1]} of {args.lot[0]}'] if args.lot else []
    chosen += [f'job {args.job}'] if args.job else []
    return ', '.join(chosen).capitalize() if chosen else 'Items'


def _lines(jobs: Sequence[JobRecord], args: argparse.Namespace) -> Iterator[str]:
    if args.b2mml:
        responses = map(response_of_record, jobs)
        return (json_of(b2mml(one)) for one in responses if one is not None)
    return _json(jobs, args) if args.json else job_text(jobs, with_items=args.items)


def _json(jobs: Sequence[JobRecord], args: argparse.Namespace) -> Iterator[str]:
    for job in jobs:
        plain = job_to_plain(job)
        plain.setdefault('status', job.status)
        plain['counts'] = all_counts(job.counts)
        if not args.items:
            plain.pop('items', None)
        yield json_of(plain)
