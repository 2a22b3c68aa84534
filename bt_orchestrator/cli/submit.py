"""The verb `submit`: give a running node work orders."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from bt_orchestrator.cli.node_options import add_node_options, add_who_options, origin
from bt_orchestrator.cli.order_request import add_request, order_message, show_orders
from bt_orchestrator.model.jobs.order import WorkOrder

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
    from bt_orchestrator_interfaces.srv import QueueAdd

    from bt_orchestrator.ros.link.client import NodeClient

    request = add_request(args.orders)
    request.who, request.origin, request.reason = args.who, origin(), args.reason or ''
    with NodeClient(args.node, args.timeout) as client:
        response = client.call(QueueAdd, 'queue/add', request)
    return show_orders(response, as_json=args.json)


def submit(client: Any, order: WorkOrder) -> Any:
    """Submit one order and return the response (srv/SubmitOrder)."""
    from bt_orchestrator_interfaces.srv import SubmitOrder

    message = order_message(order)
    fields = {name: getattr(message, name) for name in message.get_fields_and_field_types()}
    request = SubmitOrder.Request(**fields, origin=origin())
    return client.call(SubmitOrder, 'submit_order', request)
