"""The account of what is still going on: asked again and again, it reads what is new."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.events import Event, OperatorDecided
from bt_orchestrator.model.keeping.records import Extent
from bt_orchestrator.ports import Records
from bt_orchestrator.view.report.account.account import Account, Source, account_of, with_steps
from bt_orchestrator.view.report.account.beginning import fold_with_books
from bt_orchestrator.view.report.account.booked import steady_time
from bt_orchestrator.view.report.account.calendar import Now, Turn
from bt_orchestrator.view.report.account.figures import LACKS, Paces
from bt_orchestrator.view.report.account.losses import WORDS, is_stop
from bt_orchestrator.view.report.account.period import Period
from bt_orchestrator.view.report.account.plain import account_plain
from bt_orchestrator.view.report.account.planned import us_of
from bt_orchestrator.view.report.account.standing import Cause
from bt_orchestrator.view.report.account.words import percent
from bt_orchestrator.view.report.line_stops import gives_later
from bt_orchestrator.view.report.reading import Reading

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Stopped:
    """The present loss of the line."""

    cause: Cause
    since_us: int
    """Not before the period began."""
    stop: str = ''
    """The name of this stop; empty: this loss is none."""


@dataclass(frozen=True)
class Live:
    """An account up to a moment, and what goes on then."""

    now: Now
    account: Account
    """Its period ends at the moment, or where the shift ended."""
    stopped: Stopped | None
    """None: the line produces, or no shift runs."""

    @property
    def runs(self) -> bool:
        """Tell whether it is not over."""
        return self.account.period.end_us < self.now.period.end_us


class LiveAccount:
    """Reads a journal on, from the begin of the shift that runs; begins anew with each shift.

    It begins anew, too, if the journal has another history, or lacks events that it has not read.
    """

    def __init__(
        self,
        period_at: Callable[[float], Now],
        cell: Cell | None,
        tell: Callable[[str], None] = log.warning,
    ) -> None:
        """Prepare.

        :param period_at: what is asked for at a time, in seconds since the epoch
        :param cell: for the pace; None: there is none
        :param tell: called with a sentence for everything that cannot be shown
        """
        self._period_at = period_at
        self._paces = Paces(cell)
        self._tell = tell
        self._going: _Going | None = None

    def look(self, records: Records, time: float) -> Live | None:
        """Return the account at a moment; None: the journal has no event yet.

        :param time: seconds since the epoch, by the clock of the reader
        :raises JournalUnusable: it cannot be read
        """
        now = self._period_at(time)
        extent = records.extent()
        if not extent.last_seq:
            return None
        going = self._going
        if going is None or going.period != now.period or not going.goes_on(extent):
            going = self._going = None
            going = self._going = _Going(Reading(records, self._tell), now.period, extent)
        going.read(records)
        if going.is_outdated:
            going = self._going = _Going(Reading(records, self._tell), now.period, extent)
            going.read(records)
        return going.told(now, us_of(time), self._paces, extent)


class _Going:
    """The account of one period, as far as it was read."""

    def __init__(self, reading: Reading, period: Period, extent: Extent) -> None:
        self.period = period
        """By the clock."""
        self._reading = reading
        self._history, self._known = extent.history, extent.last_seq
        self._steady = steady_time(reading)
        self._steps = len(self._steady.steps)
        self._has_new_reason = False
        self._period = period = period.on(self._steady)
        self._fold, self._wanted = fold_with_books(reading, period)
        self._state_seq = self._wanted.after_seq
        self._first = self._last = 0
        """Numbers of the events in the period."""
        self._heard_us = max(period.begin_us, self._fold.begun_us)
        """Time of the latest event: the clock of the reader may be behind that of the node."""
        self._cause = self._fold.cause
        self._since_us = max(period.begin_us, self._fold.since_us)

    def goes_on(self, extent: Extent) -> bool:
        """Tell whether the journal goes on from where it was read to."""
        seq = self._wanted.after_seq
        return (
            extent.history == self._history and extent.first_seq <= seq + 1 <= extent.last_seq + 1
        )

    @property
    def is_outdated(self) -> bool:
        """Tell whether events since it was begun say something new of the time before.

        The clock was set, and may have shown the hours of the period at another time; or a stop
        was classified that is added up already.
        """
        return self._has_new_reason or len(self._steady.steps) != self._steps

    def read(self, records: Records) -> None:
        """Take in what is new."""
        self._reading.records = records
        is_last = False
        while not is_last:
            page = self._reading.page(self._wanted)
            if page.history != self._history:
                return  # it begins anew when it is asked next
            for event in map(self._steady.of, self._reading.known(page)):
                self._take(event)
            self._wanted, is_last = page.rest, page.is_last
        # What comes from now on may say something new of the period, also when that is over.
        self._wanted = replace(self._wanted, until=None).past(self._known)

    def _take(self, event: Event) -> None:
        if isinstance(event, OperatorDecided) and gives_later(event):
            self._has_new_reason = True
        time = us_of(event.time)
        if time > self._period.end_us:
            return
        if time >= self._period.begin_us:
            self._first, self._last = self._first or event.seq, event.seq
        is_first = not self._fold.has_begun
        self._fold.follow(event)
        self._heard_us = max(self._heard_us, time)
        if is_first or self._fold.cause != self._cause:
            self._cause, self._since_us = self._fold.cause, max(time, self._period.begin_us)

    def told(self, now: Now, time_us: int, paces: Paces, extent: Extent) -> Live:
        whole = self._period
        time_us -= self._steady.ahead_of(extent.last_seq)
        end = min(max(time_us, self._heard_us), whole.end_us)
        period = replace(whole, end_us=end).cut()
        source = Source(extent, self._first, self._last, self._reading.lost, self._state_seq)
        source = with_steps(source, self._reading, period)
        account = account_of(self._fold, period, paces, source)
        is_over = end >= whole.end_us
        cause = None if is_over else self._cause
        stopped = self._stopped(cause, extent.history) if cause else None
        return Live(now._replace(period=whole), account, stopped)

    def _stopped(self, cause: Cause, history: str) -> Stopped:
        name = f'{history}:{self._fold.name}' if is_stop(cause.loss) else ''
        return Stopped(cause, self._since_us, name)


# A live account as one line for a terminal, and as plain data.


def live_plain(live: Live) -> dict[str, Any]:
    """Return what a report says, and what goes on."""
    period, next_one, stopped = live.account.period, live.now.next, live.stopped
    return {
        **account_plain(live.account),
        'runs': live.runs,
        'ends': period.iso(live.now.period.end_us) if live.now.turn else None,
        'next': None if next_one is None else _turn(next_one),
        'stopped': None
        if stopped is None
        else {
            'loss': stopped.cause.loss.value,
            'detail': stopped.cause.detail,
            'component': stopped.cause.component,
            'hold': stopped.cause.hold or None,
            'since': period.iso(stopped.since_us),
            'stop': stopped.stop or None,
        },
    }


def live_line(live: Live) -> str:
    """Return the most important of it on one line."""
    period, shown, stopped = live.account.period, live.account.figures, live.stopped
    factors = ' x '.join(map(percent, (shown.availability, shown.performance, shown.quality)))
    parts = [
        f'{period.clock(period.end_us)}  {period.name}: OEE {percent(shown.oee)} = {factors}',
        f'made {shown.produced}, {shown.good} of them good',
    ]
    if shown.lack is not None:
        parts.append(LACKS[shown.lack])
    if stopped is not None:
        parts.append(f'{cause_words(stopped.cause)} since {period.clock(stopped.since_us)}')
    if not live.runs:
        parts.append(over_words(live))
    return ', '.join(parts)


def cause_words(cause: Cause) -> str:
    """Say what time is lost to, with its component."""
    about = cause.detail
    if cause.component not in about:
        about = f'{cause.component}, {about}'
    return ', '.join(filter(None, (WORDS[cause.loss].title, about)))


def over_words(live: Live) -> str:
    """Say that no shift runs, and when the next one begins."""
    next_one = live.now.next
    if next_one is None:
        return 'it is over'
    return f'it is over; {next_one.shift} begins {next_one.period.when(next_one.period.begin_us)}'


def _turn(turn: Turn) -> dict[str, Any]:
    return {'shift': turn.shift, 'begins': turn.period.iso(turn.period.begin_us)}
