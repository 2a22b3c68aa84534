"""Work orders in files as requests to a running node, and its answers as text."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from bt_orchestrator.errors import Finding, Refused
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.jobs.order import WorkOrder
from bt_orchestrator.script.lookup import is_path
from bt_orchestrator.script.orders.order_file import read_order


def orders_in(files: Sequence[Path]) -> list[WorkOrder]:
    """Return the orders in some files, for a node.

    :raises Refused: with every mistake in all files
    """
    findings: list[Finding] = []
    orders = []
    for file in files:
        try:
            orders.append(for_node(read_order(file).order))
        except Refused as refused:
            findings += refused.findings
    if findings:
        raise Refused(findings)
    return orders


def for_node(order: WorkOrder) -> WorkOrder:
    """Return an order as another folder understands it."""
    return replace(order, script=script_name(order.script))


def script_name(name: str) -> str:
    """Return a script's name, or its absolute path, for the node runs in another folder."""
    return str(Path(name).absolute()) if name and is_path(name) else name


def show_orders(answer: Answer, *, as_json: bool) -> int:
    """Print what became of orders; returns 1 if they were refused."""
    if as_json:
        for one in answer.orders:
            plain = {'accepted': answer.accepted, 'job': one.job, 'message': one.message}
            print(json.dumps({**plain, 'findings': one.findings}))
    elif answer.accepted:
        print(answer.message)
    else:
        for one in answer.orders:
            print('\n'.join([one.message, *one.findings]), file=sys.stderr)
    if not answer.orders:
        print(answer.message, file=sys.stderr)
    return 0 if answer.accepted else 1
