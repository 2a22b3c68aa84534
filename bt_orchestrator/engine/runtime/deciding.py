"""One function for each request decides what it does, and each sender needs permission (7.1)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any

from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.model import events as e
from bt_orchestrator.model.by import By, Control
from bt_orchestrator.model.commands import Command, OnRecord, RefusedRequest
from bt_orchestrator.model.requests import Request, refusal
from bt_orchestrator.model.state import CellState
from bt_orchestrator.model.words import sentence

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
        DECIDERS.update((request.name, decider) for request in requests)
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


def is_elsewhere(state: CellState, by: By | None) -> bool:
    """Tell whether a sender may move nothing now: the line is in local, and this is no panel.

    :param by: None: the plan of a virtual run
    """
    return state.control is Control.LOCAL and by is not None and not by.known.is_panel


def not_from_there(state: CellState, command: Command) -> str | None:
    """Say why a command cannot come from where it comes from now (7.8); None: it can."""
    request, by = getattr(command, 'request', None), getattr(command, 'by', None)
    if request is None or by is None:
        return None
    if request.needs_local and state.control is not Control.LOCAL:
        return sentence('not_in_remote', request=request.name)
    if not request.moves or not is_elsewhere(state, by):
        return None
    sender = {'who': by.named, 'known': by.known.value}
    return sentence('not_in_local', request=request.name, **sender)


# The record of every command, carried out or refused: who, from where and why.


def signature(by: By | None, state: CellState) -> Iterator[e.Event]:
    """Yield the record of the key that has signed a command, once (semantics 7.12).

    It precedes the record of the command.
    """
    signed = None if by is None else by.signed
    if signed is not None and signed.number > state.signatures.get(signed.public, 0):
        yield e.RequestSigned(**signed._asdict())


def decided(word: str, by: By | None, **about: Any) -> Iterator[e.Event]:
    """Yield the record of a command that is carried out; it precedes the command's events.

    :param about: the field that names its subject, and the code of a reason if it has one
    """
    if by is not None:
        yield e.OperatorDecided(answer=word, **_said(by), **about)


def refused(command: OnRecord, why: CommandRefused) -> Iterator[e.OperatorRefused]:
    """Yield the record of a refused command, one for each order that it names."""
    if command.by is None:
        return
    word = command.verb if isinstance(command, RefusedRequest) else command.request.word
    names = getattr(command, 'names', ())
    about = [{'job': name} if name else {} for name in names] or [dict(command.about)]
    messages = (names and why.each) or [str(why)] * len(about)
    for subject, message in zip(about, messages, strict=True):
        yield e.OperatorRefused(command=word, **_said(command.by), **subject, message=message)


def _said(by: By) -> dict[str, Any]:
    """Return the recorded fields of the sender."""
    return {
        'who': by.who,
        'origin': by.origin,
        'reason': by.reason,
        'role': by.role.value,
        'known': by.known.value,
        'claims': by.claims,
    }
