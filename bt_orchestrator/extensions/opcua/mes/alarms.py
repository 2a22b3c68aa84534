"""Everything that waits for people, as facts of OPC UA conditions.

Conditions are what does not end by itself: holds, the time after `abort`, a journal that cannot be
written, a contested component. A starved or blocked line goes on by itself, a cell that a person
stopped stands as it was asked to, and a node that is away is told by the quality of every value.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from bt_orchestrator.model import stop_reason
from bt_orchestrator.model.goal import Reason
from bt_orchestrator.model.hold_words import hold_words
from bt_orchestrator.model.packml import VERBS, Cause
from bt_orchestrator.model.state import Hold
from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.model.stop_reason import StopReason


@dataclass(frozen=True)
class StopId:
    """A reason in numbers."""

    number: int
    """ID of PackML's StopReason."""
    word: str
    """The stop reason, or the reason of a hold."""
    severity: int
    """Of its condition, from 1 to 1000 as in OPC UA; 0: it raises none."""
    meaning: str

    @property
    def category(self) -> int:
        """Category of PackML's StopReason."""
        return self.number // 100


NONE = StopId(0, '', 0, 'the line does not stand still')
STOPPED = StopId(100, 'stopped', 0, 'a person stopped the cell with jobs on the line')
OTHER = StopId(200, 'own_fault', 600, 'another fault')
STARVED = StopId(300, 'starved', 0, 'the source is not ready; the line goes on by itself')
BLOCKED = StopId(400, 'blocked', 0, 'the sink is not ready; the line goes on by itself')
EMERGENCY = StopId(
    500, 'emergency', 900, '`abort` was commanded, and the belt not confirmed since'
)
JOURNAL = StopId(600, 'journal', 1000, 'the node cannot write its journal, and commands nothing')
CONTEST = StopId(
    610, 'contested', 800, 'a component has several servers, or runs a goal of another client'
)

_OF_HOLDS = (
    StopId(101, stop_reason.PAUSED, 200, 'a person paused the cell'),
    StopId(201, Reason.SERVER_UNAVAILABLE.value, 600, 'no action server came in time'),
    StopId(202, Reason.GOAL_REJECTED.value, 600, 'the server refused the goal'),
    StopId(203, Reason.ABORTED.value, 600, 'the server aborted the goal'),
    StopId(204, Reason.CANCELED.value, 600, 'the orchestrator cancelled the goal'),
    StopId(205, Reason.TIMEOUT.value, 600, 'the task took too long'),
    StopId(206, Reason.TASK_RESULT_FALSE.value, 600, 'the server says that it was not done'),
    StopId(207, Reason.MISSING_RESULT.value, 600, 'the task needs a result that is not there'),
    StopId(208, Reason.SERVER_LOST.value, 700, 'the server that had the goal is gone'),
    StopId(209, Reason.IN_DOUBT.value, 700, 'it is not known how far the task came'),
    StopId(210, Reason.RESULT_REFUSED.value, 600, 'the verdict of the task refuses its result'),
    StopId(213, Reason.DUPLICATE_SERIAL.value, 600, 'the serial that was read is in the history'),
    StopId(214, Reason.SETUP_MISSING.value, 600, 'the component has another setup'),
    StopId(211, 'slot_occupied', 600, 'an item stands where another one would be placed'),
    StopId(212, 'overrun', 600, 'the belt would carry an item out of the last section'),
    StopId(221, stop_reason.RESTARTED, 500, 'a node took over unfinished work'),
    StopId(222, stop_reason.RESTORED, 800, 'the journal was restored from a backup'),
    StopId(223, stop_reason.MISSING, 800, 'written events are lost from the journal'),
    StopId(224, stop_reason.TWIN, 800, 'another node answers under the name of this one'),
    StopId(
        225, stop_reason.UNKNOWN_GOAL, 800, 'a server runs a goal that the journal does not know'
    ),
    StopId(227, stop_reason.SAFETY, 900, 'the safety input was lost'),
    StopId(226, stop_reason.TOO_MANY_REJECTS, 500, 'too many items in a row were rejected'),
)

STOP_IDS: tuple[StopId, ...] = tuple(
    sorted(
        (NONE, STOPPED, OTHER, STARVED, BLOCKED, EMERGENCY, JOURNAL, CONTEST, *_OF_HOLDS),
        key=lambda stop: stop.number,
    )
)
"""All of them, in order."""

_BY_HOLD: Mapping[str, StopId] = {stop.word: stop for stop in _OF_HOLDS}
_BY_REASON: Mapping[StopReason, StopId] = {
    StopReason.OPERATOR: STOPPED,
    StopReason.OWN_FAULT: OTHER,
    StopReason.STARVED: STARVED,
    StopReason.BLOCKED: BLOCKED,
    StopReason.EMERGENCY: EMERGENCY,
}


def id_of_hold(hold: Hold) -> StopId:
    """Return the number of a hold's reason."""
    return _BY_HOLD.get(hold.reason, OTHER)


def deciding_hold(status: CellStatus) -> Hold | None:
    """Return the oldest hold: it decides the stop reason (semantics 7.2), but for `abort`."""
    if status.stop_reason in (StopReason.OPERATOR, StopReason.OWN_FAULT) and status.holds:
        return status.holds[0]
    return None


def id_of_stop(status: CellStatus) -> StopId:
    """Return the number of what makes the line stand still."""
    if status.journal_failure:
        return JOURNAL
    if status.stop_reason is None:
        return NONE
    hold = deciding_hold(status)
    return _BY_REASON[status.stop_reason] if hold is None else id_of_hold(hold)


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
    text = f'the cell was aborted ({status.stop_message})' if status.stop_message else 'aborted'
    return f'{text}; say what stands on the belt with clear'


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
