"""Everything that waits for people, as facts of OPC UA conditions.

Conditions are what does not end by itself: holds, the time after `abort`, a journal that cannot be
written, a contested component. A starved or blocked line goes on by itself, a cell that a person
stopped stands as it was asked to, and a node that is away is told by the quality of every value.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from bt_orchestrator.extensions.opcua.mes.stop_ids import (
    CONTEST,
    EMERGENCY,
    JOURNAL,
    StopId,
    id_of_hold,
)
from bt_orchestrator.model.hold_words import hold_words
from bt_orchestrator.model.packml import VERBS, Cause
from bt_orchestrator.model.state import Hold
from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.model.stop_reason import StopReason

EMERGENCY_KEY = 'Emergency'
"""Of the condition from `abort` to `clear`."""


def hold_key(hold: str) -> str:
    """Return the key of a hold's condition."""
    return f'Hold-{hold}'


@dataclass(frozen=True)
class Alarm:
    """One condition while it is active."""

    key: str
    """Names it as long as the journal: Hold-3, Emergency, Journal, Contest-gripper."""
    reason: StopId
    message: str
    source: str
    """Path of what it is about: Sections/2, Components/gripper; empty: the whole cell."""
    since: float | None
    """Seconds since the epoch; None: not known."""
    hold: str = ''
    """Number of the hold; empty: no hold."""
    answers: tuple[str, ...] = ()
    """The present answers to the hold."""
    controller_said: str = ''
    """Text of the controller's own result; empty: it gave none, or no task is held."""
    last_feedback: str = ''
    """Last feedback of the failed attempt, as one JSON object; empty: there was none."""

    @property
    def severity(self) -> int:
        """From 1 to 1000, as in OPC UA."""
        return self.reason.severity

    @property
    def text(self) -> str:
        """The message, with the possible answers."""
        return (
            f'{self.message}; answers: {", ".join(self.answers)}' if self.answers else self.message
        )


def alarms_of(status: CellStatus) -> Mapping[str, Alarm]:
    """Return the active conditions of a cell by key, in the order of the status."""
    return {alarm.key: alarm for alarm in _alarms(status)}


def _alarms(status: CellStatus) -> Iterator[Alarm]:
    if status.journal_failure:
        yield Alarm('Journal', JOURNAL, status.journal_failure, '', status.state_since)
    if status.stop_reason is StopReason.EMERGENCY:
        words, since = _emergency(status), _aborted_at(status)
        yield Alarm(EMERGENCY_KEY, EMERGENCY, words, '', since)
    for hold in status.holds:
        yield Alarm(
            hold_key(hold.id),
            id_of_hold(hold),
            hold_words(hold),
            _place(hold),
            hold.since,
            hold.id,
            hold.answers,
            hold.controller_said,
            hold.last_feedback,
        )
    for component in status.components:
        if component.contested:
            words = f'{component.name}: {component.contested}'
            source = f'Components/{component.name}'
            yield Alarm(f'Contest-{component.name}', CONTEST, words, source, None)


def _emergency(status: CellStatus) -> str:
    said = f'the cell was aborted ({status.stop_message})' if status.stop_message else 'aborted'
    return f'{said}; say what stands on the belt with clear'


def _aborted_at(status: CellStatus) -> float | None:
    wish = status.wish
    return (
        wish.time
        if wish is not None and wish.command == VERBS[Cause.ABORT] and wish.time
        else None
    )


def _place(hold: Hold) -> str:
    if hold.component:
        return f'Components/{hold.component}'
    return f'Sections/{hold.section}' if hold.section else ''


def event_id(history: str, alarm: Alarm, what: str = '') -> bytes:
    """Return the EventId of one notification: the same after a restart of the server.

    :param history: journal of the cell
    :param what: what the notification says beside the facts; empty: it says that it is active
    """
    since = '' if alarm.since is None else f'{alarm.since:.6f}'
    facts = (history, alarm.key, since, alarm.message, *alarm.answers, what)
    return hashlib.sha256('\0'.join(facts).encode()).digest()[:16]
