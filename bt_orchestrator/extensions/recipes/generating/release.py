"""The option `--release`: a running node may use the script that comes of it."""

from __future__ import annotations

import argparse

from bt_orchestrator.cli.door import ask_and_print
from bt_orchestrator.cli.node_options import add_node_options, add_who_options
from bt_orchestrator.cli.wrong_use import WrongUse
from bt_orchestrator.extensions.recipes.generating.inputs import Inputs
from bt_orchestrator.extensions.recipes.generating.making import Made
from bt_orchestrator.model.codec import digest


def add_release_options(parser: argparse.ArgumentParser) -> None:
    """Declare the option, and who asks which node."""
    parser.add_argument(
        '--release',
        action='store_true',
        help='then ask the running node to let its jobs start (engineer); with -o or --check, '
        'and --reason',
    )
    add_who_options(parser, required=False)
    add_node_options(parser)


def check_release_options(args: argparse.Namespace) -> None:
    """Refuse a release of what stands in no file, or for no reason.

    :raises WrongUse: says what is missing
    """
    if not args.release:
        return
    if (args.output is None and args.check is None) or args.json:
        raise WrongUse('--release goes with -o FILE or --check FILE, and without --json')
    if not args.reason:
        raise WrongUse('--release needs --reason: why, for the record')


def release(args: argparse.Namespace, made: Made, inputs: Inputs) -> int:
    """Ask the node; returns 1 if it refuses."""
    script, cell = digest(made.generated.script), digest(inputs.cell)
    return ask_and_print(args, 'script.release_script', script=script, cell_digest=cell)
