"""The verb `journal`: what is done with the file of a journal while no node has it."""

from __future__ import annotations

import argparse
from pathlib import Path

from bt_orchestrator.store.sqlite.restoring import bring_back

DESCRIPTION = """\
Restore a backup: `journal restore COPY FILE` makes FILE of COPY. COPY is a copy that SQLite's
.backup made, or the files of a node that was stopped; it is only read. The next node on FILE holds
the cell (hold `restored`), also with --auto-resume, until a person has compared belt and queue."""

EPILOG = """\
exit status: 0 brought back, 1 refused (no journal was changed), 2 wrong use"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    parser.epilog = EPILOG
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument('action', choices=('restore',), help='what to do')
    parser.add_argument('copy', type=Path, metavar='COPY', help='the backup')
    parser.add_argument('journal', type=Path, metavar='FILE', help='the journal to be')
    parser.add_argument(
        '--move-aside',
        action='store_true',
        help='give a FILE that is there another name; without this it is refused',
    )


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns the exit status."""
    done = bring_back(args.copy, args.journal, move_aside=args.move_aside)
    if done.aside is not None:
        print(f'the journal that was there is {done.aside} now')
    print(
        f'{args.journal} goes on after event {done.last_seq} of {args.copy}, as history '
        f'{done.history}; the next node holds the cell until somebody has looked at the line'
    )
    return 0
