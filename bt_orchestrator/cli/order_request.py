"""Work orders as requests to a running node, and its answers as text."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from bt_orchestrator.cli.order_terms import given_terms
from bt_orchestrator.errors import Finding, Refused
from bt_orchestrator.model.jobs.order import WorkOrder
from bt_orchestrator.script.lookup import is_path
from bt_orchestrator.script.orders.order_file import read_order


def add_request(files: Sequence[Path]) -> Any:
    """Return a request (srv/QueueAdd) for the orders in some files.

    :raises Refused: with every mistake in all files
    """
    from bt_orchestrator_interfaces.srv import QueueAdd

    findings: list[Finding] = []
    orders = []
    for file in files:
        try:
            orders.append(order_message(read_order(file).order))
        except Refused as refused:
            findings += refused.findings
    if findings:
        raise Refused(findings)
    return QueueAdd.Request(orders=orders)


def order_message(order: WorkOrder) -> Any:
    """Return a work order as a message; the node looks scripts up in its own folders."""
    from bt_orchestrator_interfaces.msg import WorkOrder as Message

    return Message(
        order=order.order or '',
        script=script_name(order.script),
        quantity=order.quantity or 0,
        params=key_values(order.params),
        **given_terms(order.terms),
    )


def script_name(name: str) -> str:
    """Return a script's name, or its absolute path, for the node runs in another folder."""
    return str(Path(name).absolute()) if name and is_path(name) else name


def key_values(params: Mapping[str, Any]) -> list[Any]:
    """Return parameters as messages, values written as in YAML."""
    from diagnostic_msgs.msg import KeyValue

    return [
        KeyValue(key=key, value=value if isinstance(value, str) else json.dumps(value))
        for key, value in params.items()
    ]


def show_orders(response: Any, *, as_json: bool) -> int:
    """Print what became of orders (srv/QueueAdd); returns 1 if they were refused."""
    if as_json:
        for answer in response.answers:
            plain = {'accepted': response.accepted, 'job': answer.job, 'message': answer.message}
            print(json.dumps({**plain, 'findings': list(answer.findings)}))
    elif response.accepted:
        print(response.message)
    else:
        for answer in response.answers:
            print('\n'.join([answer.message, *answer.findings]), file=sys.stderr)
    if not response.answers:
        print(response.message, file=sys.stderr)
    return 0 if response.accepted else 1
