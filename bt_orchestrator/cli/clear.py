"""The verb `clear`: say what stands on the belt after an abort."""

from __future__ import annotations

import argparse
import re

from bt_orchestrator.cli.door import ask_and_print
from bt_orchestrator.cli.node_options import add_node_options, add_who_options

DESCRIPTION = """\
Confirm or correct the belt of a cell that was aborted; it is Stopped then. Look at the belt and at
`status`. If they agree, name the seq that `status` prints; it is refused if the belt has changed
since. Otherwise say of every slot what really stands there: an item that is not there any more is
taken out, anything else that differs is refused with what to do about it."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    statement = parser.add_mutually_exclusive_group(required=True)
    statement.add_argument(
        '--as-shown', type=_seq, default=0, metavar='SEQ', help='the belt is as that status shows'
    )
    statement.add_argument(
        '--belt', default='', metavar='SLOTS', help='every slot, as in 1=WO-1/3,2=empty,3=WO-1/1'
    )
    add_who_options(parser)
    add_node_options(parser)


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns 1 when it was refused."""
    # A comma may be part of an order's id.
    belt = re.split(r',(?=\s*\d+\s*=)', args.belt) if args.belt else None
    return ask_and_print(args, 'cell.clear', belt=belt, as_shown=args.as_shown or None)


def _seq(word: str) -> int:
    if not word.isdecimal() or not 0 < int(word) < 2**64:
        raise argparse.ArgumentTypeError(f'expected the seq that `status` prints, found {word!r}')
    return int(word)
