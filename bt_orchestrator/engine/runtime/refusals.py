"""The record of refused commands: the first ones singly, further ones as a count (7.1)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from bt_orchestrator.engine.runtime.ledger import Ledger
from bt_orchestrator.model import events as e
from bt_orchestrator.model.allowance import Allowances
from bt_orchestrator.model.by import By
from bt_orchestrator.model.codec import to_text
from bt_orchestrator.model.frozen import changed
from bt_orchestrator.model.limits import (
    MESSAGE,
    NAME,
    ORIGIN,
    REASON,
    REFUSALS,
    REFUSALS_OF_ONE,
    WHO,
    cut,
)
from bt_orchestrator.model.texts import readable
from bt_orchestrator.model.ticket import without_ticket

TOLD_EVERY_S = 60.0
"""Seconds between two records of counted refusals."""

_SENDERS = 5
"""Number of senders with a count of their own; all others share one."""

_COMMANDS, _ALL_OTHERS = 10, '...'
"""Number of commands counted separately in it, and the word for all others."""

_LONGEST = {'who': WHO, 'origin': ORIGIN, 'reason': REASON, 'message': MESSAGE}

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

    def record(self, refusals: Iterable[e.OperatorRefused]) -> None:
        """Record refusals, or count them if there are too many."""
        for refused in map(_shortened, refusals):
            sender, now = sender_of(refused), self._ledger.steady
            size = len(to_text(refused).encode())
            if size <= self._allowances.left(sender, now):
                self._allowances.use(sender, size, now)
                self._ledger.record([refused])
            else:
                self._count(sender, refused)

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


def sender_of(said: By | e.OperatorRefused) -> tuple[str, str]:
    """Return the sender whose limits apply: name and origin, without the ticket of one command."""
    return said.who, without_ticket(said.origin)


def _shortened(refused: e.OperatorRefused) -> e.OperatorRefused:
    texts = {name: value for name, value in vars(refused).items() if isinstance(value, str)}
    return changed(
        refused,
        **{name: cut(readable(text), _LONGEST.get(name, NAME)) for name, text in texts.items()},
    )


def _told(counted: dict[tuple[str, str], _Counted]) -> Iterator[e.RequestRefused]:
    for (who, origin), one in counted.items():
        yield e.RequestRefused(
            who=who,
            origin=origin,
            count=one.commands.total(),
            since=one.since,
            commands=dict(one.commands),
            message=one.message,
        )
