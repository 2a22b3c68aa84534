"""The verb `submit`: give a running node work orders."""

from __future__ import annotations

import argparse
from pathlib import Path

from bt_orchestrator.cli.door import answer_within_s, asked, open_door
from bt_orchestrator.cli.node_options import add_node_options, add_who_options
from bt_orchestrator.cli.ordering.order_request import orders_in, show_orders

DESCRIPTION = """\
Give a running tree node work orders, in the order named: all are queued, or none. The node looks
scripts up by name in its own folders; a path is made absolute here. `queue add` can do more."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    parser.add_argument('orders', nargs='+', type=Path, metavar='ORDER', help='work order (YAML)')
    parser.add_argument('--json', action='store_true', help='one JSON object an order')
    add_who_options(parser, required=False)
    add_node_options(parser)


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns 1 when the orders were refused."""
    request = asked(args, 'queue.add', orders=orders_in(args.orders))
    with open_door(args.node, args.timeout, answer_s=answer_within_s(request)) as door:
        answer = door.ask(request)
    return show_orders(answer, as_json=args.json)
