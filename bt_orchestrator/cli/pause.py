"""The verb `pause`: a command to the cell."""

from __future__ import annotations

import argparse

from bt_orchestrator.cli.cell_command import add_command_options, command


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = 'Let the cell start nothing more; what runs goes on to its end.'
    add_command_options(parser)


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns 1 when it was refused."""
    return command('pause', args)
