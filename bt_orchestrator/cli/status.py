"""The verb `status`: how a running node's cell stands."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from contextlib import closing
from datetime import datetime
from pathlib import Path
from typing import NamedTuple

from bt_orchestrator.base.errors import NotKept
from bt_orchestrator.cli.door import open_door
from bt_orchestrator.cli.node_options import add_node_options
from bt_orchestrator.cli.numbers import moment
from bt_orchestrator.cli.output import WrongUse
from bt_orchestrator.model.keeping.journal_place import JournalPlace, journal_place
from bt_orchestrator.model.keeping.records import Wanted
from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.ports import Records
from bt_orchestrator.view.screen.advice import Shell
from bt_orchestrator.view.screen.machine import plain_status
from bt_orchestrator.view.screen.words import status_lines


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = (
        'Print how the cell of a running tree node stands, or, with --at, how it stood.'
    )
    parser.add_argument('--json', action='store_true', help='the whole status as one JSON object')
    add_past_options(parser)
    add_node_options(parser)


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns the exit status."""
    if args.at is not None:
        return _past(args)
    if args.journal is not None or args.cell is not None:
        raise WrongUse('status: --journal and --cell are for --at; without it the node is asked')
    with open_door(args.node, args.timeout) as door:
        status = door.status()
    if args.json:
        print(json.dumps(plain_status(status)))
    else:
        print('\n'.join(status_lines(status, Shell(args.node))))
    return 0


def _past(args: argparse.Namespace) -> int:
    if args.journal is None or args.cell is None:
        raise WrongUse('status --at: name the journal and the cell, with --journal and --cell')
    past = status_at(args.at, args.journal, args.cell)
    if args.json:
        print(json.dumps(plain_status(past.status)))
    else:
        print('\n'.join(past_lines(past)))
    return 0


# How a cell stood at a past moment, from its journal.


def event_or_moment(text: str) -> int | float:
    """Return the number of an event, or seconds since the epoch.

    :raises ArgumentTypeError: it is neither
    """
    return int(text) if text.isdecimal() and len(text) < 19 else moment(text)


class PastStatus(NamedTuple):
    """How a cell stood."""

    status: CellStatus
    is_last: bool
    """Whether the journal ends with the event before that moment."""


def status_at(at: int | float, journal: JournalPlace, cell: Path) -> PastStatus:
    """Return how a cell stood.

    :param at: the number of an event, or seconds since the epoch
    :raises NotKept: that moment is not in the journal
    :raises JournalUnusable: the journal cannot be read
    :raises Refused: the cell file, with every mistake in it
    """
    # Imported here: engine and readers take longer to import than a running node takes to answer.
    from bt_orchestrator.cli import bootstrap
    from bt_orchestrator.cli.journal_file import open_records
    from bt_orchestrator.sim.past import JournalPast

    known = bootstrap.load_cell(cell, bootstrap.installed_types())
    with closing(open_records(journal)) as records:
        by_number = isinstance(at, int)
        seq = at if isinstance(at, int) else _last_before(records, at)
        status = JournalPast(known, records).status_at(seq, None if by_number else at)
        return PastStatus(status, is_last=seq == records.extent()[2])


def past_lines(past: PastStatus) -> Iterator[str]:
    """Yield a past status as text, marked as of the past."""
    status = past.status
    when = datetime.fromtimestamp(status.stamp).isoformat(' ', 'milliseconds')
    last = ', the last of the journal' if past.is_last else ''
    yield f'PAST, at {when}, after event {status.seq}{last}:'
    yield from status_lines(status, None)


def add_past_options(parser: argparse.ArgumentParser) -> None:
    """Declare which moment is meant, and where it is found."""
    parser.add_argument(
        '--at',
        type=event_or_moment,
        metavar='SEQ|TIME',
        help='how it stood after this event, or at this time, for instance 2026-05-17T14:30:05; '
        'from the journal, and no node has to run',
    )
    parser.add_argument(
        '--journal', type=journal_place, metavar='FILE', help='with --at: the journal'
    )
    parser.add_argument(
        '--cell', type=Path, metavar='CELL', help='with --at: the cell file as it was then'
    )


def _last_before(records: Records, time: float) -> int:
    """Return the last event up to a time.

    :raises NotKept: there is none
    """
    page = records.page(Wanted(until=time, newest_first=True), 1)
    while not page.records and not page.is_last:
        page = records.page(page.rest, 1)
    if not page.records:
        when = datetime.fromtimestamp(time).isoformat(' ', 'seconds')
        raise NotKept(f'the journal has no event of {when} or before; name a later time')
    return page.records[0].seq
