"""Books: the account of a journal in slots of time, kept when its events are removed.

What is in a slot, in a state and in a script is told by `report.account`; here it is text.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from bt_orchestrator.model.keeping.records import Damage


class KeptSlot(NamedTuple):
    """The account from one moment to another."""

    begin_us: int
    """Microseconds since the epoch; at most one slot begins there."""
    until_us: int
    made_of: int
    """Seq of the last event that has a say in it."""
    version: int
    """Of what the text means."""
    text: str


class KeptState(NamedTuple):
    """The facts for going on after an event."""

    seq: int
    now_us: int
    """Up to when its time is in slots."""
    made_of: int
    stays: bool
    """False: it is needed until there is a newer one."""
    version: int
    text: str


class KeptScript(NamedTuple):
    """A script whose work is in the journal."""

    digest: str
    text: str


class KeptReason(NamedTuple):
    """A decision that says the reason of a stop."""

    made_of: int
    """Seq of its event."""
    text: str
    """The record of the event."""


@dataclass(frozen=True)
class Books:
    """Books made from some events, to be kept all at once."""

    history: str
    """Of the events."""
    reached: int
    """Seq of the last event that is in them."""
    is_last: bool
    """There were no further events."""
    slots: Sequence[KeptSlot] = ()
    states: Sequence[KeptState] = ()
    scripts: Sequence[KeptScript] = ()
    reasons: Sequence[KeptReason] = ()

    def to_bytes(self) -> bytes:
        """Return it in the form between processes."""
        rows = [self.slots, self.states, self.scripts, self.reasons]
        return json.dumps([self.history, self.reached, self.is_last, *rows]).encode()

    @classmethod
    def from_bytes(cls, message: bytes) -> Books:
        """Return what was sent."""
        history, reached, is_last, slots, states, scripts, reasons = json.loads(message)
        return cls(
            history,
            reached,
            is_last,
            [KeptSlot(*slot) for slot in slots],
            [KeptState(*state) for state in states],
            [KeptScript(*script) for script in scripts],
            [KeptReason(*reason) for reason in reasons],
        )


@dataclass(frozen=True)
class SlotPage:
    """Some of the slots of a journal, in order."""

    slots: Sequence[KeptSlot]
    damage: Sequence[Damage]
    rest_us: int | None
    """The place at which to ask for more; None: this is the end."""


@dataclass(frozen=True)
class ReasonPage:
    """Some of the reasons that were given for stops, in order."""

    reasons: Sequence[KeptReason]
    damage: Sequence[Damage]
    rest_seq: int | None
    """The seq after which to ask for more; None: this is the end."""


class WithoutBooks:
    """Records without books: their part of `ports.Records`."""

    def booked(
        self,
        begin_us: int,  # noqa: ARG002 - the port's
        end_us: int,  # noqa: ARG002
        most: int = 1000,  # noqa: ARG002
        *,
        newest_first: bool = False,  # noqa: ARG002
    ) -> SlotPage:
        """Return no books."""
        return SlotPage((), (), None)

    def book_state(self, at_us: int, first_seq: int = 0) -> None:
        """Return no state: there are no books."""

    def book_script(self, digest: str) -> None:
        """Return no script: there are no books."""

    def book_reasons(self, after_seq: int = 0, most: int = 1000) -> ReasonPage:  # noqa: ARG002
        """Return no reasons: there are no books."""
        return ReasonPage((), (), None)
