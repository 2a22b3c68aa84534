"""Where commands come in: each checked and recorded, at a rate that the disk can take."""

from __future__ import annotations

import dataclasses

from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.engine.runtime.command_record import refused
from bt_orchestrator.engine.runtime.commands import answer_to
from bt_orchestrator.engine.runtime.ledger import Ledger
from bt_orchestrator.engine.runtime.refusals import Refusals, sender_of
from bt_orchestrator.model.allowance import Allowances
from bt_orchestrator.model.by import By
from bt_orchestrator.model.codec import to_text
from bt_orchestrator.model.commands import (
    Answer,
    Command,
    FoundTwin,
    OnRecord,
    RefusedRequest,
    Shutdown,
)
from bt_orchestrator.model.limits import COMMANDS, COMMANDS_OF_ONE, NAME, ORIGIN, REASON, WHO
from bt_orchestrator.model.requests import Asked, Why
from bt_orchestrator.model.texts import readable, text_fault

_LONGEST = {'who': WHO, 'origin': ORIGIN, 'reason': REASON}


class Inbox:
    """Answers commands, one after the other."""

    def __init__(self, ledger: Ledger) -> None:
        self._ledger = ledger
        self._refusals = Refusals(ledger)
        self._allowances = Allowances(COMMANDS_OF_ONE, COMMANDS)

    def take(self, command: Command) -> Answer:
        """Carry out a command, or refuse it and say why."""
        self._ledger.look_at_clock()
        if isinstance(command, Shutdown):
            self._refusals.tell()
        if isinstance(command, (Shutdown, FoundTwin)):
            return Answer(accepted=True, message=answer_to(command, self._ledger))
        try:
            return Answer(accepted=True, message=self._carry_out(command))
        except CommandRefused as why:
            self._refusals.record(refused(command, why))
            return Answer(accepted=False, message=str(why), each=why.each)

    def land(self) -> None:
        """Record counted refusals that are due, at the beginning of a settle."""
        self._refusals.land()

    def _carry_out(self, command: OnRecord) -> str:
        if not isinstance(command, RefusedRequest):  # it says more than a limit would
            command = _as_may_be_recorded(command)
            _check_texts(command)
        if command.by is None:
            return answer_to(command, self._ledger)
        sender, now = sender_of(command.by), self._ledger.steady
        if not isinstance(command, RefusedRequest) and command.request.is_limited:
            _check_left(command.by, self._allowances.left(sender, now))
        before = self._ledger.state.seq
        message = answer_to(command, self._ledger)
        written = sum(len(to_text(event)) for event in self._ledger.pending_after(before))
        self._allowances.use(sender, written, now)
        return message


def _check_left(by: By, left: float) -> None:
    if left <= 0:
        seconds = 1 - left / COMMANDS_OF_ONE.per_s
        raise CommandRefused(
            f'too many commands: {by.who or "this sender"}, or all senders together, have filled '
            'the journal as fast as they may; nothing was done; give it again in '
            f'{seconds:.0f} s (abort, stop, pause and answers to holds are always taken)'
        )


def _as_may_be_recorded(command: OnRecord) -> OnRecord:
    """Return a command of an emergency with readable words: it must not fail because of them."""
    if not isinstance(command, Asked) or command.request.why is not Why.AFTERWARDS:
        return command
    by = dataclasses.replace(
        command.sender,
        who=readable(command.sender.who),
        origin=readable(command.sender.origin),
        reason=readable(command.sender.reason),
    )
    return dataclasses.replace(command, by=by)


def _check_texts(command: OnRecord) -> None:
    """Refuse a command with a text that is too long to record, or shows other than it says."""
    said = {} if command.by is None else vars(command.by)
    given = command.arguments if isinstance(command, Asked) else vars(command)
    for name, text in {**given, **said}.items():
        longest = _LONGEST.get(name, NAME)
        if isinstance(text, str) and len(text) > longest:
            raise CommandRefused(
                f'{name} has {len(text)} characters; expected at most {longest}; nothing was done'
            )
    for name, text in said.items():
        fault = text_fault(text) if isinstance(text, str) else None
        if fault is not None:
            raise CommandRefused(
                f'{name} cannot be recorded: {fault}; write it without; nothing was done'
            )
