"""Reasons of waits without item ids: equal waits can be summed up."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from bt_orchestrator.model.wait import Wait, WaitKind


class Cause(NamedTuple):
    """The cause of a wait."""

    kind: WaitKind
    text: str


def cause_words(causes: Sequence[Cause]) -> str:
    """Name what is waited for, all of it at once."""
    return ' and '.join(cause.text for cause in causes)


def kind_words(causes: Sequence[Cause]) -> str:
    """Return the kinds of waits, joined by +, each once."""
    return '+'.join(dict.fromkeys(cause.kind.value for cause in causes))


_TEXTS = {
    WaitKind.BELT: 'the belt, which moves',
    WaitKind.ITEM: 'an item',
    WaitKind.FLAG: 'flag {name}',
    WaitKind.ZONE: 'zone {name}',
    WaitKind.COMPONENT: '{name}, busy elsewhere',
    WaitKind.READINESS: '{name} to be ready',
    WaitKind.OUT_OF_SERVICE: '{name}, out of service',
    WaitKind.INITIALIZATION: 'initialization {name}',
    WaitKind.HOLD: 'an answer to a hold',
    WaitKind.PAUSE: 'the cell to be resumed',
    WaitKind.RETRY_DELAY: 'the delay before a retry',
    WaitKind.CELL_STATE: 'the cell, which is {name}',
}


def cause_of(wait: Wait, belt: Sequence[Wait]) -> Cause:
    """Return the cause of a wait.

    :param belt: what the belt waits for now; nothing while it moves
    """
    if wait.kind is WaitKind.TURN:
        return Cause(wait.kind, f'the {_turns(wait.sections)}')
    if wait.kind is WaitKind.JOB:
        return Cause(wait.kind, _job(wait))
    if wait.kind is WaitKind.BELT and belt:
        return Cause(wait.kind, f'the belt: {cause_of(belt[0], ()).text.removeprefix("the ")}')
    return Cause(wait.kind, _TEXTS[wait.kind].format(name=wait.name))


def _turns(sections: Sequence[int]) -> str:
    *others, last = map(str, sections)
    if not others:
        return f'turn of section {last}'
    return f'turns of sections {", ".join(others)} and {last}'


def _job(wait: Wait) -> str:
    if not wait.sections:
        return 'a job'
    return f'section {wait.sections[0]} to finish {wait.name}'
