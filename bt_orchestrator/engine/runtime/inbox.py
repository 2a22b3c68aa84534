"""Where commands come in: each checked and recorded, refused ones too, at a rate for the disk."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.engine.runtime.commands import answer_to
from bt_orchestrator.engine.runtime.deciding import refused, signature
from bt_orchestrator.engine.runtime.ledger import Ledger
from bt_orchestrator.model import events as e
from bt_orchestrator.model.by import By, without_ticket
from bt_orchestrator.model.codec import to_text
from bt_orchestrator.model.commands import (
    Answer,
    Command,
    FoundTwin,
    OnRecord,
    RefusedRequest,
    Shutdown,
)
from bt_orchestrator.model.frozen import changed
from bt_orchestrator.model.limits import (
    COMMANDS,
    COMMANDS_OF_ONE,
    MESSAGE,
    NAME,
    ORIGIN,
    REASON,
    REFUSALS,
    REFUSALS_OF_ONE,
    WHO,
    Allowances,
    cut,
)
from bt_orchestrator.model.requests import Asked, Why
from bt_orchestrator.model.texts import readable, text_fault
from bt_orchestrator.model.words import joined, sentence

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
            self._refusals.record(refused(command, why), command.by)
            return Answer(accepted=False, message=str(why), each=why.each)

    def land(self) -> None:
        """Record counted refusals that are due, at the beginning of a settle."""
        self._refusals.land()

    def _carry_out(self, command: OnRecord) -> str:
        if not isinstance(command, RefusedRequest):  # it says more than a limit would
            _check_lengths(command)  # first: it takes no time, however long the texts are
            command = _as_may_be_recorded(command)
            _check_characters(command)
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
        who = by.who or 'this sender'
        raise CommandRefused(sentence('too_many_commands', who=who, seconds=f'{seconds:.0f}'))


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


def _check_lengths(command: OnRecord) -> None:
    """Refuse a command with a text that is too long to record."""
    given = command.arguments if isinstance(command, Asked) else vars(command)
    for name, text in {**given, **_sender_texts(command)}.items():
        longest = _LONGEST.get(name, NAME)
        if isinstance(text, str) and len(text) > longest:
            words = sentence('too_many_characters', field=name, count=len(text), most=longest)
            raise CommandRefused(joined(words, sentence('nothing_done')))


def _check_characters(command: OnRecord) -> None:
    """Refuse a command with a text of its sender that shows other than it says."""
    for name, text in _sender_texts(command).items():
        fault = text_fault(text) if isinstance(text, str) else None
        if fault is not None:
            raise CommandRefused(sentence('not_recorded', field=name, words=fault))


def _sender_texts(command: OnRecord) -> Mapping[str, object]:
    return {} if command.by is None else vars(command.by)


# The record of refused commands: the first ones singly, further ones as a count (7.1).

TOLD_EVERY_S = 60.0
"""Seconds between two records of counted refusals."""

_SENDERS = 5
"""Number of senders with a count of their own; all others share one."""

_COMMANDS, _ALL_OTHERS = 10, '...'
"""Number of commands counted separately in it, and the word for all others."""

_LONGEST_KEPT = {'who': WHO, 'origin': ORIGIN, 'reason': REASON, 'message': MESSAGE}

_SHORT = 200
"""Characters of the last message in a record of counted refusals."""


@dataclass
class _Counted:
    """Refusals of one sender since the last record of them."""

    since: float
    commands: Counter[str] = field(default_factory=Counter)
    message: str = ''

    def add(self, refused: e.OperatorRefused) -> None:
        known = refused.command in self.commands or len(self.commands) < _COMMANDS
        self.commands[cut(refused.command, 20) if known else _ALL_OTHERS] += 1
        self.message = cut(refused.message, _SHORT)


class Refusals:
    """Records refusals, and keeps the records few, however many requests there are."""

    def __init__(self, ledger: Ledger) -> None:
        self._ledger = ledger
        self._allowances = Allowances(REFUSALS_OF_ONE, REFUSALS)
        self._counted: dict[tuple[str, str], _Counted] = {}
        self._tell_at: float | None = None

    def record(self, refusals: Iterable[e.OperatorRefused], by: By | None) -> None:
        """Record refusals of a sender, or count them if there are too many."""
        for refusal in map(_shortened, refusals):
            sender, now = sender_of(refusal), self._ledger.steady
            events = [*signature(by, self._ledger.state), refusal]
            size = sum(len(to_text(event).encode()) for event in events)
            if size <= self._allowances.left(sender, now):
                self._allowances.use(sender, size, now)
                self._ledger.record(events)
            else:
                self._count(sender, refusal)

    def land(self) -> None:
        """Record the counts, if they are due."""
        if self._tell_at is not None and self._ledger.steady >= self._tell_at:
            self.tell()

    def tell(self) -> None:
        """Put on record what was counted."""
        counted, self._counted, self._tell_at = self._counted, {}, None
        self._ledger.record(_told(counted))

    def _count(self, sender: tuple[str, str], refused: e.OperatorRefused) -> None:
        if self._tell_at is None:
            self._tell_at = self._ledger.steady + TOLD_EVERY_S
            self._ledger.wake_at(self._tell_at)
        if sender not in self._counted and len(self._counted) >= _SENDERS:
            sender = ('', '')
        self._counted.setdefault(sender, _Counted(self._ledger.now)).add(refused)


def sender_of(source: By | e.OperatorRefused) -> tuple[str, str]:
    """Return the sender whose limits apply: name and origin, without the ticket of one command."""
    return source.who, without_ticket(source.origin)


def _shortened(refused: e.OperatorRefused) -> e.OperatorRefused:
    texts = {name: value for name, value in vars(refused).items() if isinstance(value, str)}
    return changed(
        refused,
        **{
            name: readable(cut(text, _LONGEST_KEPT.get(name, NAME)))
            for name, text in texts.items()
        },
    )


def _told(counted: dict[tuple[str, str], _Counted]) -> Iterator[e.RequestRefused]:
    for (who, origin), tally in counted.items():
        yield e.RequestRefused(
            who=who,
            origin=origin,
            count=tally.commands.total(),
            since=tally.since,
            commands=dict(tally.commands),
            message=tally.message,
        )
