"""One function for each request decides what it does, and each sender needs permission (7.1)."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from bt_orchestrator.model import events as e
from bt_orchestrator.model.commands import Command
from bt_orchestrator.model.requests import Request, refusal
from bt_orchestrator.model.state import CellState

Decided = tuple[str, Iterable[e.Event]]
"""The words of the answer, and what happens; the record of the request precedes it."""

Decider = Callable[[CellState, Any, float], Decided]
"""Of state, request and time. It changes nothing.

:raises CommandRefused: before its first event; says why
"""

DECIDERS: dict[str, Decider] = {}
"""By the name of the request."""


def decides(*requests: Request) -> Callable[[Decider], Decider]:
    """Make a function the decider of some requests."""

    def register(decider: Decider) -> Decider:
        DECIDERS.update((one.name, decider) for one in requests)
        return decider

    return register


def not_allowed(command: Command) -> str | None:
    """Say why the sender has no permission for a command; None: it has.

    A command without a sender comes from the plan of a virtual run.
    """
    request, by = getattr(command, 'request', None), getattr(command, 'by', None)
    if request is None or by is None:
        return None
    return refusal(request, by, getattr(command, 'arguments', ()))
