"""The verbs `reset` and `start`, and what they have in common with `pause`, `stop` and `abort`."""

from __future__ import annotations

import argparse

from bt_orchestrator.cli.door import ask_and_print
from bt_orchestrator.cli.node_options import add_node_options, add_who_options

DESCRIPTION = """\
Command the cell of a running tree node. What each command does in which state is in
docs/operating.md; one that is not possible now is refused with those that are."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of these verbs."""
    parser.description = DESCRIPTION
    add_who_options(parser)
    add_node_options(parser)


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns 1 when it was refused."""
    return ask_and_print(args, f'cell.{args.verb}')
