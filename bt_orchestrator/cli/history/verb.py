"""The verb `history`: which jobs and items a journal knows, and what became of them."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path

from bt_orchestrator.cli.history.chart import chart_svg, no_job
from bt_orchestrator.cli.history.forecast import (
    add_forecast_options,
    forecast_text,
    refuse_contradictions,
)
from bt_orchestrator.cli.history.item_records import (
    as_html,
    as_json,
    histories,
    refuse_too_many,
)
from bt_orchestrator.cli.journal_file import open_records, say_damage
from bt_orchestrator.cli.moments import add_period_options
from bt_orchestrator.cli.output import opened
from bt_orchestrator.cli.wrong_use import WrongUse
from bt_orchestrator.errors import OrchestratorError
from bt_orchestrator.mes.job_response import b2mml, response_of_record
from bt_orchestrator.model.codec import json_of
from bt_orchestrator.model.jobs.job_record import ItemRecord, JobRecord, job_to_plain
from bt_orchestrator.model.script import Script
from bt_orchestrator.report.job_text import job_text
from bt_orchestrator.report.reading import Reading
from bt_orchestrator.script.writing.script_text import Comments, write_script

DESCRIPTION = """\
Print the jobs of a journal, oldest first: when they ran, how they ended, how many items became
what, and why attempts failed. The journal is only read; its node may run or not."""


class NoScript(OrchestratorError):
    """A journal does not have the script of a job any more."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    parser.add_argument('--journal', type=Path, required=True, metavar='FILE', help='the journal')
    parser.add_argument('--job', metavar='JOB', help='this job only')
    parser.add_argument(
        '--item',
        action='append',
        metavar='ITEM',
        help='this item only, and its job, as WO-7/3; may be repeated',
    )
    parser.add_argument('--items', action='store_true', help='also every item, with its results')
    parser.add_argument(
        '--serial', metavar='SERIAL', help='items of this serial only, and their jobs'
    )
    parser.add_argument(
        '--lot',
        type=_lot,
        metavar='NAME=LOT',
        help='items that this went into only, and their jobs, as glue=L-77',
    )
    as_json = parser.add_mutually_exclusive_group()
    as_json.add_argument(
        '--script',
        action='store_true',
        help='with --job: the script that it ran, as a file, in place of the table',
    )
    as_json.add_argument('--json', action='store_true', help='one JSON object a job and line')
    as_json.add_argument(
        '--html',
        action='store_true',
        help='with --item, --serial, --lot or --job: the whole record of each item as a document, '
        'for a browser and for paper: attempts, results, waits and why, holds and who answered',
    )
    as_json.add_argument(
        '--record', action='store_true', help='the same as JSON, one object an item and line'
    )
    as_json.add_argument(
        '--b2mml',
        action='store_true',
        help='the same as job responses for an MES, with the names of B2MML; jobs that have '
        'started',
    )
    as_json.add_argument(
        '--gantt',
        action='store_true',
        help='draw what each component really did, as SVG: in the time of --job, or of --from and '
        '--to, which then name times of the work',
    )
    parser.add_argument(
        '-o', '--output', type=Path, metavar='FILE', help='where; else the standard output'
    )
    add_forecast_options(parser)
    add_period_options(parser, 'jobs queued')


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns 1 if a job is not there, or a record is damaged."""
    if args.script and args.job is None:
        raise WrongUse('--script prints what one job ran; say which: --job JOB')
    is_record = args.html or args.record
    if is_record and not (args.item or args.serial or args.lot or args.job):
        raise WrongUse(
            '--html and --record are about items; say which: --item ITEM, --serial SERIAL, '
            '--lot NAME=LOT or --job JOB'
        )
    if args.gantt and args.job is not None and not (args.since is args.until is None):
        raise WrongUse('--job, or --from and --to, name the time of the chart; leave one out')
    refuse_contradictions(args)
    lacks: list[str] = []

    def say(sentence: str) -> None:
        lacks.append(sentence)
        say_damage(sentence)

    with closing(open_records(args.journal)) as records:
        reading = Reading(records, say)
        if args.gantt or args.forecast:
            return _drawn_or_compared(reading, args)
        jobs = _jobs(reading, args)
        if args.job is not None and not jobs:
            print(no_job(args), file=sys.stderr)
            return 1
        if args.item or args.serial or args.lot:
            args.items, jobs = True, list(_with_items(jobs, args))
            if not jobs:
                print(f'the journal {args.journal} {_none(args)}', file=sys.stderr)
                return 1
        text = _records(jobs, reading, args, lacks) if is_record else _table(jobs, reading, args)
        with opened(args.output) as file:
            file.write(text)
    return 1 if reading.lost else 0


def _drawn_or_compared(reading: Reading, args: argparse.Namespace) -> int:
    text = forecast_text(reading, args) if args.forecast else chart_svg(reading, args)
    with opened(args.output) as file:
        file.write(text)
    return 1 if reading.lost else 0


def _jobs(reading: Reading, args: argparse.Namespace) -> list[JobRecord]:
    """Read the jobs that may be meant; for items that are named, theirs alone."""
    names = {one.rpartition('/')[0] for one in args.item or ()}
    job = args.job or (names.pop() if len(names) == 1 else None)
    return [one for one in reading.jobs(job).jobs.values() if _is_wanted(one, args)]


def _none(args: argparse.Namespace) -> str:
    if not args.item:
        return 'has no such item any more'
    named = ' and no '.join(args.item)
    return (
        f'knows no item {named}: it never was, or its events are not kept any more; '
        'history --job JOB --items names the items of a job'
    )


def _table(jobs: Sequence[JobRecord], reading: Reading, args: argparse.Namespace) -> str:
    lines = _script(jobs[0], reading, args.journal) if args.script else _lines(jobs, args)
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


def _script(job: JobRecord, reading: Reading, journal: Path) -> Iterator[str]:
    """Yield the text of the script that a job ran.

    :raises NoScript: the journal has it no more
    """
    script = reading.script(job.digest) if job.digest else None
    if script is None:
        raise NoScript(
            f'the script of {job.job} is not kept any more in {journal}; a backup of the journal '
            'may have it'
        )
    if _origin(script) != (job.recipe, job.recipe_version):
        script = replace(script, made_from=None)  # an equal one, of another version of the recipe
    head = [f'What job {job.job} ran, by the journal; time limits of components are written out.']
    if job.params:
        head.append(f'Its parameters: {json_of(job.params)}')
    yield write_script(script, None, Comments(head)).rstrip()


def _origin(script: Script) -> tuple[str, int | None]:
    made_from = script.made_from
    return (made_from.recipe, made_from.version) if made_from else ('', None)


def _lot(text: str) -> tuple[str, str]:
    name, equals, lot = text.partition('=')
    if not (name and equals and lot):
        raise argparse.ArgumentTypeError(f'a lot is NAME=LOT, found {text!r}')
    return name, lot


def _with_items(jobs: Sequence[JobRecord], args: argparse.Namespace) -> Iterator[JobRecord]:
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
