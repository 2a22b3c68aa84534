"""The verb `submit`: give a running node work orders."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from bt_orchestrator.cli.node_options import add_node_options
from bt_orchestrator.model.order import WorkOrder
from bt_orchestrator.script.lookup import is_path
from bt_orchestrator.script.order_file import read_order

DESCRIPTION = """\
Give a running tree node work orders, in the order named. The node looks scripts up by name in its
own folders; a path is made absolute here."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options of the verb."""
    parser.description = DESCRIPTION
    parser.add_argument('orders', nargs='+', type=Path, metavar='ORDER', help='work order (YAML)')
    parser.add_argument('--json', action='store_true', help='one JSON object an order')
    add_node_options(parser)


def run(args: argparse.Namespace) -> int:
    """Carry out the verb; returns 1 when an order was refused."""
    from bt_orchestrator.ros.client import NodeClient

    orders = [read_order(path).order for path in args.orders]
    with NodeClient(args.node, args.timeout) as client:
        answers = [submit(client, order) for order in orders]
    for answer in answers:
        _show(answer, as_json=args.json)
    return 0 if all(answer.accepted for answer in answers) else 1


def submit(client: Any, order: WorkOrder) -> Any:
    """Submit one order and return the response."""
    from bt_orchestrator_interfaces.srv import SubmitOrder
    from diagnostic_msgs.msg import KeyValue

    request = SubmitOrder.Request(
        order=order.order or '',
        script=str(Path(order.script).absolute()) if is_path(order.script) else order.script,
        quantity=order.quantity or 0,
        params=[
            KeyValue(key=key, value=value if isinstance(value, str) else json.dumps(value))
            for key, value in order.params.items()
        ],
    )
    return client.call(SubmitOrder, 'submit_order', request)


def _show(answer: Any, *, as_json: bool) -> None:
    if as_json:
        plain = {
            'accepted': answer.accepted,
            'job': answer.job,
            'message': answer.message,
            'findings': list(answer.findings),
        }
        print(json.dumps(plain))
        return
    print(answer.message, file=sys.stdout if answer.accepted else sys.stderr)
    for finding in answer.findings:
        print(finding, file=sys.stderr)
