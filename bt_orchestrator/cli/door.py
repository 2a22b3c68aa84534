"""The door to a running node, and asking through it: the one place where verbs meet ROS 2."""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from bt_orchestrator.cli.node_options import KEY_VARIABLE, origin
from bt_orchestrator.cli.output import WrongUse
from bt_orchestrator.model.by import By
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.jobs.job_control import REQUEUE
from bt_orchestrator.model.limits import GENERATING_S
from bt_orchestrator.model.requests import Asked, BadArguments, ask
from bt_orchestrator.model.status import CellStatus

STEP_S = 0.1
"""Longest time between two looks at whether to stop."""

if TYPE_CHECKING:  # it needs rclpy, which takes its time
    from bt_orchestrator.ros.link.ros_link import RosLink
    from bt_orchestrator.script.users.keys import SigningKey


def open_door(
    node: str,
    timeout_s: float,
    meanwhile: Callable[[], object] | None = None,
    answer_s: float | None = None,
    key: SigningKey | None = None,
) -> RosLink:
    """Open the door to a node (`ports.CellLink`); a context that closes it.

    :param timeout_s: longest time to wait for the node and for each of its answers
    :param meanwhile: called again and again while it waits; what it raises ends the waiting
    :param answer_s: longest time to wait for an answer, if it is longer
    :param key: signs all requests; None: they go unsigned
    """
    from bt_orchestrator.ros.link.ros_link import RosLink

    if _other is not None:
        return cast('RosLink', _other)
    return RosLink(node, timeout_s, meanwhile, answer_s, key)


_other: object | None = None


@contextmanager
def instead_of_a_door(other: AbstractContextManager[object]) -> Iterator[None]:
    """Let verbs open something else: it has what they use of a door, and a node need not be."""
    global _other  # noqa: PLW0603 - verbs are called one after another
    _other = other
    try:
        yield
    finally:
        _other = None


def asked(args: argparse.Namespace, name: str, **given: Any) -> Asked:
    """Return a request of whoever typed a verb (`model.requests`).

    :raises WrongUse: it has other arguments
    """
    try:
        return ask(name, By(args.who, origin(), args.reason or ''), **given)
    except BadArguments as error:
        raise WrongUse(str(error)) from error


def ask_and_print(
    args: argparse.Namespace, name: str, *, as_json: bool = False, **given: Any
) -> int:
    """Ask something of a node and print its answer; returns 1 if it was refused."""
    request = asked(args, name, **given)
    with door_for(args, request) as door:
        answer = door.ask(request)
        # Print before leaving the graph: the answer must not be lost if leaving fails.
        _show(answer, as_json=as_json)
    return 0 if answer.accepted else 1


def door_for(args: argparse.Namespace, request: Asked | None = None) -> RosLink:
    """Open the door for requests, which are signed where a key is named (semantics 7.12).

    :param request: None: its answer takes no longer than any
    :raises KeyUnusable: there is no such key; says what to do
    """
    answer_s = None if request is None else answer_within_s(request)
    return open_door(args.node, args.timeout, answer_s=answer_s, key=signing_key(args))


def signing_key(args: argparse.Namespace) -> SigningKey | None:
    """Return the key that the options or the environment name; None: neither does.

    :raises KeyUnusable: it cannot be used; says what to do
    """
    from bt_orchestrator.script.users.keys import SigningKey

    path = args.sign_with or os.environ.get(KEY_VARIABLE)
    return SigningKey(Path(path)) if path else None


def answer_within_s(request: Asked) -> float | None:
    """Return how long the answer to a request may take; None: as long as any other.

    A script is generated first for an order by recipe, and for the rest of a job.
    """
    given = request.arguments
    orders: Any = given.get('orders', ())
    is_ordered = bool(given.get('recipe')) or any(order.recipe for order in orders)
    return GENERATING_S if is_ordered or request.request.method is REQUEUE else None


def _show(answer: Answer, *, as_json: bool) -> None:
    findings = [finding for order in answer.orders for finding in order.findings]
    if as_json:
        plain = {'accepted': answer.accepted, 'message': answer.message}
        print(json.dumps({**plain, 'findings': findings}), flush=True)
    else:
        stream = sys.stdout if answer.accepted else sys.stderr
        print('\n'.join([answer.message, *findings]), file=stream, flush=True)


class Ignoring:
    """A listener (`ports.Listener`) that ignores everything; a base for partial listeners."""

    def on_status(self, status: CellStatus) -> None:
        """Take no note."""

    def on_event(self, event: Event) -> None:
        """Take no note."""

    def on_gap(self, first: int, last: int) -> None:
        """Take no note."""

    def on_history(self, history: str) -> None:
        """Take no note."""
