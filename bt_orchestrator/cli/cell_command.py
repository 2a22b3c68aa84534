"""The verbs that command a running cell: `reset`, `start`, `pause`, `stop`, `abort`."""

from __future__ import annotations

import argparse
from typing import Any

from bt_orchestrator.cli.node_options import add_node_options, add_who_options, call_and_print


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of these verbs."""
    parser.description = (
        'Command the cell of a running tree node. What each command does in which state is in '
        'docs/operating.md; one that is not possible now is refused with those that are.'
    )
    add_who_options(parser)
    add_node_options(parser)


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns 1 when it was refused."""
    return command_cell(args)


def command_cell(args: argparse.Namespace, **fields: Any) -> int:
    """Give the command that the verb is named for, with further fields of its request."""
    from bt_orchestrator_interfaces.srv import Command

    request = Command.Request(command=args.verb, who=args.who, reason=args.reason, **fields)
    return call_and_print(args, Command, 'command', request)
