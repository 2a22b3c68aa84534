"""Work orders in files as requests to a running node, and its answers as text."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from bt_orchestrator.base.errors import CommandRefused, Finding, NodeUnreachable, Refused
from bt_orchestrator.cli.door import asked, door_for
from bt_orchestrator.model.commands import Answer, OrderAnswer
from bt_orchestrator.model.jobs.order import NO_TERMS, WorkOrder
from bt_orchestrator.script.lookup import is_path
from bt_orchestrator.script.orders.file_findings import pointed, refuse_duplicates
from bt_orchestrator.script.orders.order_file import OrderFile, OrderPlaces, draft_order

_HAS_MISTAKES = '/the file has mistakes'
"""Follows the id of an order that must not be queued: a node refuses ids with a slash."""

_CHOICE = ('script', 'recipe', 'version', 'bind')


def give_orders(args: argparse.Namespace, paths: Sequence[Path], **given: Any) -> int:
    """Give a node the orders in some files, and print the answer; 1: it refused them.

    If a file has mistakes of its own, nothing is queued. The node still reads the orders, for
    the mistakes that only it can find, so that the sender is told all of them at once.

    :raises Refused: with every mistake in all files, if one has mistakes of its own
    """
    files, findings = _drafts(paths)
    if findings:
        raise Refused(sorted({*findings, *_found_by_node(args, files, given)}))
    answer = _ask(args, [for_node(file.order) for file in files], given)
    if not answer.accepted:
        pairs = zip(answer.orders, files, strict=False)
        answer = replace(
            answer, orders=tuple(_with_lines(order_answer, file) for order_answer, file in pairs)
        )
    return _show(answer, as_json=args.json)


def for_node(order: WorkOrder) -> WorkOrder:
    """Return an order as another folder understands it."""
    return replace(order, script=script_name(order.script))


def script_name(name: str) -> str:
    """Return a script's name, or its absolute path, for the node runs in another folder."""
    return str(Path(name).absolute()) if name and is_path(name) else name


def _drafts(paths: Iterable[Path]) -> tuple[list[OrderFile], list[Finding]]:
    """Return the orders in some files, and the mistakes that are there without a script."""
    files: list[OrderFile] = []
    findings: list[Finding] = []
    for path in paths:
        try:
            file = draft_order(path)
        except Refused as refused:
            findings += refused.findings
        else:
            files.append(file)
            findings += file.places.findings
    try:
        refuse_duplicates(files)
    except Refused as refused:
        findings += refused.findings
    return files, findings


def _found_by_node(
    args: argparse.Namespace, files: Sequence[OrderFile], given: dict[str, Any]
) -> Iterator[Finding]:
    """Yield the mistakes that only the node can find; without an answer of it, say so."""
    readable = [file for file in files if all(map(file.places.is_sure, _CHOICE))]
    if not readable:
        return
    try:
        answer = _ask(args, [_not_to_be_queued(file.order) for file in readable], given)
    except (CommandRefused, NodeUnreachable) as error:
        answer = Answer(accepted=False, message=str(error))
    if not answer.accepted and not answer.orders:
        lacks = 'mistakes that only the node can find are not listed here'
        print(f'{answer.message}; {lacks}', file=sys.stderr)
    for order_answer, file in zip(answer.orders, readable, strict=False):
        doubted = file.places.doubted | {('order',)}
        yield from _in_file(order_answer, replace(file.places, doubted=doubted))


def _not_to_be_queued(order: WorkOrder) -> WorkOrder:
    name = f'{order.order or ""}{_HAS_MISTAKES}'
    params = {name: value for name, value in order.params.items() if value is not None}
    return replace(for_node(order), order=name, params=params, terms=NO_TERMS)


def _with_lines(answer: OrderAnswer, file: OrderFile) -> OrderAnswer:
    return replace(answer, findings=tuple(map(str, _in_file(answer, file.places))))


def _in_file(answer: OrderAnswer, places: OrderPlaces) -> list[Finding]:
    """Return the node's findings about an order, in the order of its file."""
    findings = (pointed(text, places) for text in answer.findings)
    return sorted(finding for finding in findings if finding is not None)


def _ask(args: argparse.Namespace, orders: list[WorkOrder], given: dict[str, Any]) -> Answer:
    request = asked(args, 'queue.add', orders=orders, **given)
    with door_for(args, request) as door:
        return door.ask(request)


def _show(answer: Answer, *, as_json: bool) -> int:
    if as_json:
        for order in answer.orders:
            plain = {'accepted': answer.accepted, 'job': order.job, 'message': order.message}
            print(json.dumps({**plain, 'findings': order.findings}))
    elif answer.accepted:
        print(answer.message)
    else:
        for order in answer.orders:
            print('\n'.join([order.message, *order.findings]), file=sys.stderr)
    if not answer.orders:
        print(answer.message, file=sys.stderr)
    return 0 if answer.accepted else 1
