"""The verb `remove-item`: record that an item was taken off the belt by hand."""

from __future__ import annotations

import argparse

from bt_orchestrator.cli.door import ask_and_print
from bt_orchestrator.cli.node_options import add_node_options, add_who_options


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = (
        'Record that an item was taken off the belt by hand; it leaves an empty position.'
    )
    parser.add_argument('item', metavar='ITEM', help='for example WO-1001/3')
    add_who_options(parser)
    add_node_options(parser)


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns 1 when it was refused."""
    return ask_and_print(args, 'item.remove_item', item=args.item)
