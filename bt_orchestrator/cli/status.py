"""The verb `status`: how a running node's cell stands."""

from __future__ import annotations

import argparse
import json

from bt_orchestrator.cli.door import open_door
from bt_orchestrator.cli.node_options import add_node_options
from bt_orchestrator.cli.past_status import add_past_options, past_lines, status_at
from bt_orchestrator.cli.wrong_use import WrongUse
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
