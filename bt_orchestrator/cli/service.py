"""The verbs `out-of-service` and `in-service`: whether a component may get goals."""

from __future__ import annotations

import argparse

from bt_orchestrator.cli.door import ask_and_print
from bt_orchestrator.cli.node_options import add_node_options, add_who_options

DESCRIPTION = """\
Take a component out of service, or bring it back. Out of service it gets no goal, what runs
goes on, and the queue passes the jobs that need it. It is no lockout: it protects nobody at the
machine. Lock out its energy before you reach into it."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of these verbs."""
    parser.description = DESCRIPTION
    parser.add_argument('component', metavar='COMPONENT', help='its name in the cell file')
    add_who_options(parser)
    add_node_options(parser)


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns 1 when it was refused."""
    word = args.verb.replace('-', '_')
    return ask_and_print(args, f'component.{word}', component=args.component)
