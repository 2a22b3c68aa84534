"""The verbs that are commands to the cell of a running node: `pause`, `resume`."""

from __future__ import annotations

import argparse

from bt_orchestrator.cli.node_options import add_node_options, add_who_options, call_and_print


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of these verbs."""
    parser.description = (
        'Command the cell. `pause`: start nothing more, what runs goes on to its end. '
        '`resume`: go on after a pause, or after a restart with unfinished work.'
    )
    add_who_options(parser)
    add_node_options(parser)


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns 1 when it was refused."""
    from bt_orchestrator_interfaces.srv import Command

    request = Command.Request(command=args.verb, who=args.who, reason=args.reason)
    return call_and_print(args, Command, 'command', request)
