"""The list of alarms of a journal, as SCADA has it: raised, acknowledged, answered, cleared.

Alarms are holds, the time after `abort`, contested components, state topics without a publisher,
and refused commands. All of it is read from the events; nothing is kept for it.
"""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from datetime import datetime, tzinfo
from enum import Enum
from typing import IO, Any, NamedTuple

from bt_orchestrator.model import events as e
from bt_orchestrator.model.keeping.records import Wanted
from bt_orchestrator.model.requests import is_remark
from bt_orchestrator.model.stop_reason import StopReason
from bt_orchestrator.view.report.account.booked import steady_time
from bt_orchestrator.view.report.account.planned import US
from bt_orchestrator.view.report.account.steady_time import SteadyTime
from bt_orchestrator.view.report.account.stops import OpenHolds
from bt_orchestrator.view.report.account.words import duration
from bt_orchestrator.view.report.csv_export import csv_cell
from bt_orchestrator.view.report.reading import Reading
from bt_orchestrator.view.report.tables import table

ACKNOWLEDGE = 'acknowledge'

FOLLOWED = (
    *('hold.', 'operator.', 'request.', 'component.', 'cell.', 'job.', 'orchestrator.', 'clock.'),
    e.ItemRemoved.event,
)
"""The events that alarms are made of, as `Wanted.events` names them."""


class Kind(Enum):
    """The kinds of alarms."""

    HOLD = 'hold'
    EMERGENCY = 'emergency'
    """From `abort` to `clear`."""
    CONTEST = 'contest'
    """Another client or server has a part in a component (semantics 2.5)."""
    SILENT = 'silent'
    """The publisher of a component's state topic is gone."""
    REFUSED = 'refused'
    """A refused command: it begins and ends at one moment."""


@dataclass
class Alarm:
    """One alarm; times in microseconds of steady time."""

    kind: Kind
    key: str
    """Number of the hold, name of the component, or name of the command."""
    words: str
    raised_us: int
    raised_at: float
    """The same by the node's clock, in seconds since the epoch."""
    component: str = ''
    job: str = ''
    reason: str = ''
    """In one word, for holds; alarms of one component and reason are alike."""
    count: int = 1
    """Refused commands of one sender that were recorded as one."""
    cleared_us: int | None = None
    """None: it stands."""
    cleared_at: float | None = None
    acknowledged_at: float | None = None
    acknowledged_by: str = ''
    answered_at: float | None = None
    answer: str = ''
    who: str = ''
    """The author of the answer, or of the refused command."""
    why: str = ''
    """The reason of the answer."""
    remarks: list[str] = field(default_factory=list)
    held: e.HoldRaised | None = None
    """The event of the hold; None: it is no hold."""

    def lasted_us(self, now_us: int) -> int:
        """Return how long it stood, or has stood by now."""
        return (now_us if self.cleared_us is None else self.cleared_us) - self.raised_us

    @property
    def likeness(self) -> tuple[str, str, str]:
        """The key by which alarms are counted together."""
        return self.kind.value, self.component or self.key, self.reason


class Often(NamedTuple):
    """How often alarms that are alike came, and how long they stood."""

    kind: str
    about: str
    """The component, or the hold's or command's name."""
    reason: str
    times: int
    us: int


class AlarmFold:
    """Takes in the events of a journal, in order; knows all its alarms."""

    def __init__(self, steady: SteadyTime) -> None:
        self.alarms: list[Alarm] = []
        """In the order in which they were raised."""
        self.now_us = 0
        """Steady time of the last event."""
        self._steady = steady
        self._open: dict[tuple[Kind, str], Alarm] = {}
        self._holds = OpenHolds()

    def follow(self, event: e.Event) -> None:
        """Take in an event."""
        steady = self._steady.of(event)
        self.now_us = round(steady.time * US)
        if isinstance(event, e.HoldRaised):
            held = self._holds.raised(event, self.now_us, event.component)
            alarm = self._raise(event, Kind.HOLD, event.hold, held.words)
            alarm.component, alarm.job, alarm.reason = (
                event.component,
                event.job or '',
                event.reason,
            )
            alarm.held = event
            return
        released = self._holds.follow(event, self.now_us)
        if released is not None and released.answer:
            self._answered(Kind.HOLD, released.hold, event, released.answer, released.who)
            self._open[Kind.HOLD, released.hold].why = released.reason
        self._other(event)

    def _other(self, event: e.Event) -> None:
        if isinstance(event, e.HoldReleased):
            self._clear(event, Kind.HOLD, event.hold)
        elif isinstance(event, e.OperatorDecided):
            self._decided(event)
        elif isinstance(event, e.OperatorRefused):
            alarm = self._raise(event, Kind.REFUSED, event.command, event.message)
            alarm.who, alarm.job = event.who, event.job or ''
            self._clear(event, Kind.REFUSED, event.command)
        elif isinstance(event, e.RequestRefused):
            alarm = self._raise(event, Kind.REFUSED, '...', event.message)
            alarm.who, alarm.count = event.who, event.count
            self._clear(event, Kind.REFUSED, '...')
        elif isinstance(event, e.StopReasonChanged):
            if event.stop_reason == StopReason.EMERGENCY.value:
                self._raise(event, Kind.EMERGENCY, 'abort', f'aborted by {event.reason}')
            else:
                self._clear(event, Kind.EMERGENCY, 'abort')
        elif isinstance(event, e.ComponentContested):
            others = ', '.join((*event.servers, *event.goals))
            self._of_component(event, Kind.CONTEST, others)
        elif isinstance(event, e.ComponentStateChanged):
            is_gone = event.value is None and not event.ready
            self._of_component(event, Kind.SILENT, 'its state topic is silent' if is_gone else '')

    def _of_component(
        self, event: e.ComponentContested | e.ComponentStateChanged, kind: Kind, words: str
    ) -> None:
        if not words:
            self._clear(event, kind, event.component)
        elif (kind, event.component) not in self._open:
            self._raise(event, kind, event.component, words).component = event.component

    def _raise(self, event: e.Event, kind: Kind, key: str, words: str) -> Alarm:
        alarm = Alarm(kind, key, words, self.now_us, event.time)
        self._open[kind, key] = alarm
        self.alarms.append(alarm)
        return alarm

    def _clear(self, event: e.Event, kind: Kind, key: str) -> None:
        alarm = self._open.pop((kind, key), None)
        if alarm is not None:
            alarm.cleared_us, alarm.cleared_at = self.now_us, event.time

    def _decided(self, event: e.OperatorDecided) -> None:
        alarm = self._open.get((Kind.HOLD, event.hold or ''))
        if alarm is None:
            if event.answer == 'clear':
                self._answered(Kind.EMERGENCY, 'abort', event, event.answer, event.who)
        elif not is_remark(event.answer):
            self._answered(Kind.HOLD, alarm.key, event, event.answer, event.who)
            alarm.why = event.reason
        else:
            if event.answer == ACKNOWLEDGE and alarm.acknowledged_at is None:
                alarm.acknowledged_at, alarm.acknowledged_by = event.time, event.who
            if event.reason:
                alarm.remarks.append(f'{event.who}: {event.reason}')

    def _answered(self, kind: Kind, key: str, event: e.Event, answer: str, who: str) -> None:
        alarm = self._open.get((kind, key))
        if alarm is not None and alarm.answered_at is None:
            alarm.answered_at, alarm.answer, alarm.who = event.time, answer, who


def alarms_of(reading: Reading) -> AlarmFold:
    """Read all alarms of a journal, as far as it has events."""
    fold = AlarmFold(steady_time(reading))
    for event in reading.events(Wanted(events=FOLLOWED)):
        fold.follow(event)
    return fold


def often(alarms: Iterable[Alarm], now_us: int) -> list[Often]:
    """Return which alarms came most; those that are alike are counted together."""
    times: Counter[tuple[str, str, str]] = Counter()
    stood: Counter[tuple[str, str, str]] = Counter()
    for alarm in alarms:
        times[alarm.likeness] += alarm.count
        stood[alarm.likeness] += alarm.lasted_us(now_us)
    groups = (Often(*key, count, stood[key]) for key, count in times.items())
    return sorted(groups, key=lambda group: (-group.times, -group.us, group[:3]))


# --- forms ------------------------------------------------------------------------------------


def alarm_lines(alarms: Iterable[Alarm], now_us: int, zone: tzinfo | None) -> Iterator[str]:
    """Yield the alarms for a terminal, the last first."""
    for alarm in sorted(alarms, key=lambda alarm: -alarm.raised_us):
        begin, end = _when(alarm.raised_at, zone), _when(alarm.cleared_at, zone) or 'stands'
        lasted = duration(alarm.lasted_us(now_us))
        span = begin if alarm.kind is Kind.REFUSED else f'{begin} to {end}, {lasted}'
        yield f'{span}  {alarm.kind.value}: {_about(alarm)}{alarm.words}'
        if alarm.acknowledged_at is not None:
            yield f'  acknowledged by {alarm.acknowledged_by} {_when(alarm.acknowledged_at, zone)}'
        yield from (f'  {remark}' for remark in alarm.remarks)
        if alarm.answer:
            why = f': {alarm.why}' if alarm.why else ''
            yield f'  {alarm.answer} by {alarm.who} {_when(alarm.answered_at, zone)}{why}'


def often_lines(groups: Iterable[Often]) -> Iterator[str]:
    """Yield which alarms came most, for a terminal."""
    rows = [
        (', '.join(filter(None, group[:3])), str(group.times), duration(group.us))
        for group in groups
    ]
    yield from table(('', 'times', 'time'), rows)


def alarm_plain(alarm: Alarm, now_us: int) -> dict[str, Any]:
    """Return an alarm for JSON and CSV; times in seconds since the epoch, null: not yet."""
    return {
        'kind': alarm.kind.value,
        'key': alarm.key,
        'component': alarm.component or None,
        'job': alarm.job or None,
        'section': alarm.held.section if alarm.held else None,
        'item': alarm.held.item if alarm.held else None,
        'task': alarm.held.task if alarm.held else None,
        'reason': alarm.reason or None,
        'words': alarm.words,
        'count': alarm.count,
        'raised': alarm.raised_at,
        'acknowledged': alarm.acknowledged_at,
        'acknowledged_by': alarm.acknowledged_by or None,
        'answered': alarm.answered_at,
        'answer': alarm.answer or None,
        'who': alarm.who or None,
        'why': alarm.why or None,
        'remarks': alarm.remarks,
        'cleared': alarm.cleared_at,
        'seconds': round(alarm.lasted_us(now_us) / US, 6),
    }


def write_alarms_csv(alarms: Iterable[Alarm], now_us: int, file: IO[str]) -> None:
    """Write a line for each alarm; empty: not yet, or none."""
    rows = [alarm_plain(alarm, now_us) for alarm in alarms]
    writer = csv.writer(file)
    head = alarm_plain(Alarm(Kind.HOLD, '', '', 0, 0.0), 0)
    writer.writerow(head)
    for row in rows:
        row['remarks'] = '; '.join(row['remarks'])
        writer.writerow(map(csv_cell, row.values()))


def _about(alarm: Alarm) -> str:
    if alarm.kind is Kind.REFUSED:
        times = f'{alarm.count} times ' if alarm.count > 1 else ''
        return f'{alarm.key} of {alarm.who or "somebody"}, {times}'
    return f'{alarm.component}: ' if alarm.kind in (Kind.CONTEST, Kind.SILENT) else ''


def _when(time: float | None, zone: tzinfo | None) -> str:
    return '' if time is None else f'{datetime.fromtimestamp(time, zone):%Y-%m-%d %H:%M:%S}'
