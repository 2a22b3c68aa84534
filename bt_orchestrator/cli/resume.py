"""The verb `resume`: a command to the cell."""

from __future__ import annotations

import argparse

from bt_orchestrator.cli.cell_command import add_command_options, command


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = 'Let the cell go on after a pause, or after a restart with unfinished work.'
    add_command_options(parser)


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns 1 when it was refused."""
    return command('resume', args)
