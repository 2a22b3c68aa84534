"""The commands to type: the answers to a hold, and the next step where a cell stands."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from typing import NamedTuple

from bt_orchestrator.model.by import Role
from bt_orchestrator.model.jobs.isa95 import OVER
from bt_orchestrator.model.packml import Cause, PackmlState
from bt_orchestrator.model.requests import About, Request, of_hold, requests_about
from bt_orchestrator.model.requests.offers import (
    alike,
    allowed,
    answers_of_others,
    may_make,
    who_may,
    worthwhile_for_cell,
)
from bt_orchestrator.model.state import Hold
from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.model.texts import one_line

PROGRAM = 'bt-orchestrator'

DEFAULT_NODE = '/bt_orchestrator'

WHY = '--reason "WHY"'


_WAITING_FOR_ORDERS = (PackmlState.STOPPED, PackmlState.IDLE, PackmlState.COMPLETE)


class Shell(NamedTuple):
    """How the reader's shell reaches one node."""

    node: str = DEFAULT_NODE
    """Full name of the tree node."""
    program: str = PROGRAM
    """The command for this program there, with variables in front where they are needed."""

    def command(self, words: str) -> str:
        """Return a command line.

        :param words: the verb with its arguments
        """
        to_node = '' if self.node == DEFAULT_NODE else f' --node {self.node}'
        return f'{self.program} {words}{to_node}'


class Choice(NamedTuple):
    """One thing that a person can do now."""

    name: str
    """In one word."""
    words: str
    """The verb with its arguments, but for the reason."""
    effect: str = ''
    needs_reason: bool = True
    who: str = ''
    """The roles that may do it, where the reader may not; empty: the reader may."""
    is_complete: bool = True
    """Nothing in the words has to be filled in."""

    def text(self) -> str:
        """Return the verb with all that has to be typed."""
        return f'{self.words} {WHY}' if self.needs_reason else self.words


def hold_advice(hold: Hold, shell: Shell, role: Role | None = None) -> list[str]:
    """Return what the reader can type about a hold, what instead, and what others may answer.

    :param role: of the reader; None: not known
    """
    commands = [shell.command(choice.text()) for choice in hold_choices(hold, role)]
    first, *others = [*allowed(hold.answers, role)] or ['']
    if others:
        commands[1:] = [f'or {", ".join(others)} in place of {first}']
    of_others = answers_of_others(hold.answers, role)
    return [*commands, *of_others, *filter(None, [one_line(hold.answers_why)])]


def hold_choices(hold: Hold, role: Role | None = None) -> tuple[Choice, ...]:
    """Return the answers that a hold offers to the reader.

    :param role: of the reader; None: not known
    """
    return tuple(
        Choice(request.word, _typed(request, hold))
        for request in of_hold(hold.answers)
        if may_make(request, role)
    )


def _typed(request: Request, hold: Hold) -> str:
    """Return the verb by which somebody answers a hold."""
    verb = request.word.replace('_', '-')
    match request.about:
        case About.ITEM:
            return f'{verb} {shlex.quote(hold.item or "")}'
        case About.CELL:
            return f'cell {verb} --hold {hold.id}'
    return f'answer {hold.id} {request.word}'


def next_choices(status: CellStatus) -> tuple[Choice, ...]:
    """Return what an operator can do when the cell stands still and does not go on by itself.

    Nothing for a cell that works, and for one that is held: a hold says what it offers.
    """
    return () if status.holds else tuple(_next_choices(status))


def _of(request: Request, status: CellStatus) -> str:
    """Name who may make a request, where the reader may not."""
    return '' if may_make(request, status.unauthenticated_role) else who_may(request)


def _next_choices(status: CellStatus) -> Iterator[Choice]:
    waits = any(job.state not in OVER for job in status.jobs) or bool(status.waits_for)
    if status.state in _WAITING_FOR_ORDERS and not waits:
        add, *_ = requests_about(About.QUEUE)
        order, effect = 'submit ORDER.yaml', 'gives it a work order'
        who = _of(add, status)
        yield Choice('submit', order, effect, needs_reason=False, who=who, is_complete=False)
    for request in worthwhile_for_cell(status):
        word, who = request.word, _of(request, status)
        if request.cause is Cause.CLEAR:
            shown = f'cell {word} --as-shown {status.seq}'
            yield Choice(word, shown, 'if the belt is as shown here', who=who)
            each = f'cell {word} --belt 1=ITEM,2=empty'
            effect = 'else: every slot as it really is'
            yield Choice(word, each, effect, who=who, is_complete=False)
        elif request.cause in (Cause.RESET, Cause.START):
            yield Choice(word, f'cell {word}', request.effect, who=who)


def alike_lines(status: CellStatus, shell: Shell) -> list[str]:
    """Return how holds that ask the same can be answered as a list."""
    lines = []
    for group in alike(status.holds):
        answers = allowed(group[0].answers_together, status.unauthenticated_role)
        if not answers:
            continue
        answer, *others = answers
        ids = ','.join(hold.id for hold in group)
        instead = f' (or {", ".join(others)})' if others else ''
        command = shell.command(f'answer {ids} {answer} {WHY}')
        lines.append(f'{command}{instead}   the holds whose robots you looked at, in one list')
    return lines


def next_lines(status: CellStatus, shell: Shell) -> list[str]:
    """Return what can be typed next, with what it does."""
    return [
        f'{choice.who} may: {command}   {choice.effect}'
        if choice.who
        else f'{command}   {choice.effect}'
        for choice in next_choices(status)
        for command in (shell.command(choice.text()),)
    ]
