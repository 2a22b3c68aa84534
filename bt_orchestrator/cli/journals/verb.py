"""The verb `journal`: what is done with a journal while no node has it."""

from __future__ import annotations

import argparse
from contextlib import closing
from pathlib import Path
from typing import cast

from bt_orchestrator.cli.journal_file import open_journal
from bt_orchestrator.cli.output import WrongUse
from bt_orchestrator.model.keeping.journal_place import journal_place
from bt_orchestrator.store.shared.copying import copy_journal
from bt_orchestrator.store.shared.journal import KeptJournal
from bt_orchestrator.store.sqlite.copying import TABLES
from bt_orchestrator.store.sqlite.restoring import bring_back

DESCRIPTION = """\
`journal restore COPY FILE` restores a backup: it makes the file FILE of COPY. COPY is a copy that
SQLite's .backup made, or the files of a node that was stopped; it is only read.

`journal copy FROM TO` copies a journal into an empty one: from a file into a database,
postgresql://USER@HOST/DATABASE/CELL, or back. It compares the copy with the journal.

The next node on either holds the cell (hold `restored`), also with --auto-resume, until a person
has compared belt and queue. Start no node on the old journal any more."""

EPILOG = """\
exit status: 0 done, 1 refused (no journal was changed), 2 wrong use"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    parser.epilog = EPILOG
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument('action', choices=('restore', 'copy'), help='what to do')
    parser.add_argument('copy', metavar='FROM', type=journal_place, help='backup, or journal')
    parser.add_argument('journal', type=journal_place, metavar='TO', help='the journal to be')
    parser.add_argument(
        '--move-aside',
        action='store_true',
        help='with restore: give a FILE that is there another name; without this it is refused',
    )


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns the exit status."""
    if args.action == 'copy':
        return _copy(args)
    if not (isinstance(args.copy, Path) and isinstance(args.journal, Path)):
        raise WrongUse('journal restore: expected two files; for a database: journal copy FROM TO')
    done = bring_back(args.copy, args.journal, move_aside=args.move_aside)
    if done.aside is not None:
        print(f'the journal that was there is {done.aside} now')
    print(
        f'{args.journal} goes on after event {done.last_seq} of {args.copy}, as history '
        f'{done.history}; the next node holds the cell until somebody has looked at the line'
    )
    return 0


def _copy(args: argparse.Namespace) -> int:
    if isinstance(args.copy, Path) and not args.copy.is_file():
        raise WrongUse(f'journal copy: there is no journal {args.copy}; check the path')
    tables = [('queued', ('seq', 'job')), *((table.name, table.columns) for table in TABLES)]
    with (
        closing(open_journal(args.copy, 'FULL')) as source,
        closing(open_journal(args.journal, 'FULL')) as target,
    ):
        done = copy_journal(cast('KeptJournal', source), cast('KeptJournal', target), tables)
    print(
        f'{args.journal} goes on after event {done.last_seq} of {args.copy}, as history '
        f'{done.history}\ncompared: {done.events} events (SHA-256 {done.digest}) and {done.rows} '
        'other rows\nthe next node holds the cell until somebody has looked at the line; start no '
        f'node on {args.copy} any more'
    )
    return 0
