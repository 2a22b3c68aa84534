"""The verbs that do not wait for a reason: `pause`, `stop`, `abort`."""

from __future__ import annotations

import argparse

from bt_orchestrator.cli import cell_command
from bt_orchestrator.cli.node_options import add_node_options, add_who_options


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of these verbs."""
    parser.description = cell_command.DESCRIPTION
    add_who_options(parser, required=False)
    add_node_options(parser)


run = cell_command.run
