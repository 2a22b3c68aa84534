"""The verb `history`: which jobs and items a journal knows, and what became of them."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import replace

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.cli.history.chart import chart_svg, jobs_meant, no_item, no_job, with_items
from bt_orchestrator.cli.history.forecast import forecast_text
from bt_orchestrator.cli.history.options import (
    add_arguments,
    chooses_items,
    is_record,
    refuse_contradictions,
)
from bt_orchestrator.cli.journal_file import open_records, say_damage
from bt_orchestrator.cli.output import WrongUse, opened
from bt_orchestrator.cli.reporting.each_cell import each_cell, with_cell
from bt_orchestrator.model.codec import json_of
from bt_orchestrator.model.jobs.job_record import JobRecord, all_counts, job_to_plain
from bt_orchestrator.model.keeping.journal_place import JournalPlace
from bt_orchestrator.model.script import Script
from bt_orchestrator.script.writing.script_text import Comments, write_script
from bt_orchestrator.view.drawing.documents.item_page import Source, item_page
from bt_orchestrator.view.report.ended_jobs import job_text
from bt_orchestrator.view.report.isa95.job_response import b2mml, response_of_record
from bt_orchestrator.view.report.item.history import ItemHistory, plain_item
from bt_orchestrator.view.report.item.reader import item_history
from bt_orchestrator.view.report.reading import Reading

__all__ = ['add_arguments', 'run']


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns 1 if a job is not there, or a record is damaged."""
    refuse_contradictions(args)
    return each_cell(args, _run, one_only=_OF_ONE_CELL, choosing=('job', 'item', 'serial', 'lot'))


_OF_ONE_CELL = ('html', 'record', 'b2mml', 'gantt', 'forecast', 'output')


def _run(args: argparse.Namespace) -> int:
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
        return (json_of(b2mml(response)) for response in responses if response is not None)
    return _json(jobs, args) if args.json else job_text(jobs, with_items=args.items)


def _json(jobs: Sequence[JobRecord], args: argparse.Namespace) -> Iterator[str]:
    for job in jobs:
        plain = job_to_plain(job)
        plain.setdefault('status', job.status)
        plain['counts'] = all_counts(job.counts)
        if not args.items:
            plain.pop('items', None)
        yield with_cell(json_of(plain), args)


# The script that a job ran, as a file.


class NoScript(OrchestratorError):
    """A journal does not have the script of a job any more."""


def script_of(job: JobRecord, reading: Reading, journal: JournalPlace) -> Iterator[str]:
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
    head = [
        f'The script that job {job.job} ran, by the journal, with the time limits of components.'
    ]
    if job.params:
        head.append(f'Its parameters: {json_of(job.params)}')
    yield write_script(script, None, Comments(head)).rstrip()


def _origin(script: Script) -> tuple[str, int | None]:
    made_from = script.made_from
    return (made_from.recipe, made_from.version) if made_from else ('', None)


# Records of single items, as JSON or as one HTML document.

MOST_ITEMS = 500
"""More than this in one document is too slow for a browser and too long for a reader."""


class NoItem(OrchestratorError):
    """A journal does not have an item."""


def histories(reading: Reading, journal: JournalPlace, items: Iterable[str]) -> list[ItemHistory]:
    """Read the records of items, in the order named.

    :raises NoItem: the journal does not have one of them
    """
    item_histories = []
    for item in items:
        history = item_history(reading, item)
        if history is None:
            raise NoItem(
                f'the journal {journal} knows no item {item}: it never was, or its events are not '
                'kept any more; `bt-orchestrator history --job JOB --items` names the items of a '
                'job'
            )
        item_histories.append(history)
    return item_histories


def refuse_too_many(items: Sequence[str]) -> None:
    """Refuse what makes no document.

    :raises WrongUse: there are too many items
    """
    if len(items) > MOST_ITEMS:
        raise WrongUse(
            f'{len(items)} items are too many for one document, which has {MOST_ITEMS} at most: '
            'choose with --serial, --job, --from and --to; --record writes them all as JSON'
        )


def as_json(items: Iterable[ItemHistory]) -> str:
    """Return records as JSON, one object an item and line."""
    return ''.join(f'{json_of(plain_item(item))}\n' for item in items)


def as_html(
    items: Sequence[ItemHistory], journal: JournalPlace, title: str, lacks: Sequence[str]
) -> str:
    """Return records as one document.

    :param lacks: what of the journal could not be read
    """
    return item_page(items, Source(f'the journal {journal}', time.time(), lacks), title)
