"""The verb `release-script`: let jobs of a generated script start."""

from __future__ import annotations

import argparse

from bt_orchestrator.cli.door import ask_and_print
from bt_orchestrator.cli.node_options import add_node_options, add_who_options

DESCRIPTION = """\
Release a script that was generated from a recipe, for the cell file that the node runs with. Its
jobs may start then, now and later. Read the script before: `generate ... --release` does both."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    parser.add_argument(
        'script',
        metavar='SCRIPT',
        help='its digest, as `status` tells it; or its name, if a job in the queue waits for it',
    )
    add_who_options(parser)
    add_node_options(parser)


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns 1 when it was refused."""
    return ask_and_print(args, 'script.release_script', script=args.script)
