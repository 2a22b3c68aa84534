"""The verb `resume`: release pauses."""

from __future__ import annotations

import argparse

from bt_orchestrator.cli.door import ask_and_print
from bt_orchestrator.cli.node_options import add_node_options, add_who_options
from bt_orchestrator.model.pauses import NAMED


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = (
        'Release your own pauses. The cell goes on when no pause and no other hold is left. The '
        f'holds {", ".join(sorted(NAMED))} ask somebody to look at the line first: each is '
        'released only by --hold.'
    )
    which = parser.add_mutually_exclusive_group()
    which.add_argument(
        '--hold',
        default='',
        metavar='N',
        help='release this pause or hold of the cell, also one of another person',
    )
    which.add_argument('--all', action='store_true', help='release the pauses of all persons')
    add_who_options(parser)
    add_node_options(parser)


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns 1 when it was refused."""
    return ask_and_print(args, 'cell.resume', hold=args.hold or None, everyones=args.all)
