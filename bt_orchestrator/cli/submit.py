"""The verb `submit`: give a running node work orders."""

from __future__ import annotations

import argparse
from pathlib import Path

from bt_orchestrator.cli.node_options import add_node_options, add_who_options
from bt_orchestrator.cli.ordering.order_request import give_orders

DESCRIPTION = """\
Give a running tree node work orders, in the order named: all are queued, or none. The node looks
scripts up by name in its own folders; a path is made absolute here. All mistakes are printed as
`check` prints them, as far as the node answers. `queue add` can do more."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    parser.add_argument('orders', nargs='+', type=Path, metavar='ORDER', help='work order (YAML)')
    parser.add_argument('--json', action='store_true', help='one JSON object an order')
    add_who_options(parser, required=False)
    add_node_options(parser)


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns 1 when the orders were refused."""
    return give_orders(args, args.orders)
