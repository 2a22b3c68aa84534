"""An account of a journal: its period, its figures, and the events that it was made from."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.keeping.records import Extent, Record, Wanted
from bt_orchestrator.view.report.account.beginning import fold_with_books
from bt_orchestrator.view.report.account.booked import (
    booked,
    first_booked,
    last_booked,
    steady_time,
)
from bt_orchestrator.view.report.account.figures import LACKS, Figures, Paces, figures
from bt_orchestrator.view.report.account.fold import FOLLOWED, AccountFold, FromBooks
from bt_orchestrator.view.report.account.losses import Loss
from bt_orchestrator.view.report.account.period import Period
from bt_orchestrator.view.report.account.planned import Planned, us_of
from bt_orchestrator.view.report.account.steady_time import SteadyTime, Step
from bt_orchestrator.view.report.account.words import (
    break_words,
    duration,
    is_seen,
    old_step_words,
    step_words,
)
from bt_orchestrator.view.report.line_stops import LineStop
from bt_orchestrator.view.report.reading import Reading

_OF_A_JOB = (e.JobStarted.event, e.JobCompleted.event, e.JobAborted.event)

_MOST_MOMENTS = 4
"""The shares are of rounded planned time."""


class NothingToReport(OrchestratorError):
    """A journal has nothing of a period, or of a job."""


@dataclass(frozen=True)
class Source:
    """The events that an account was made from."""

    extent: Extent
    first_seq: int
    last_seq: int
    """Of the events in the period, those that an account needs; 0: there is none."""
    unreadable: int
    """Damaged records: what they said is not in it."""
    state_seq: int = 0
    """The last event before the period; 0: there is none."""
    ended_us: int | None = None
    """When the journal ended, if that was before the period."""
    steps: tuple[Step, ...] = ()
    """Steps of the clock within the period."""
    not_taken_out: tuple[Step, ...] = ()
    """Those that made books of the version before leave out time."""

    def beside(self, seqs: Sequence[int]) -> Source:
        """Return it with events that were read beside books."""
        first = min((*seqs, self.first_seq)) if self.first_seq else min(seqs, default=0)
        return replace(self, first_seq=first, last_seq=max((*seqs, self.last_seq)))

    def lines(self, books: str) -> tuple[str, ...]:
        """Say it for a person.

        :param books: that it was made from, too; empty: there were none
        """
        history, first = self.extent.history, self.extent.first_seq
        events = f'events {self.first_seq} to {self.last_seq}' if self.first_seq else ''
        of = ' and '.join(filter(None, (books, events))) or self._state()
        lines = [f'made from {of} of history {history}']
        if first > 1:
            lines.append(f'events 1 to {first - 1} were removed from the journal')
        if self.unreadable:
            lines.append(f'{self.unreadable} damaged records are missing in it')
        return tuple(lines)

    def _state(self) -> str:
        if not self.state_seq:
            return 'no event'
        return f'the state that event {self.state_seq} left, as no event is in this time,'


@dataclass(frozen=True)
class Account:
    """Everything that a report says."""

    period: Period
    figures: Figures
    source: Source
    books: FromBooks
    has_cell: bool
    """A cell file was given, for the pace."""
    cell_differs: bool
    """The node ran with another cell file than the one that the pace is of."""

    @property
    def tells_reasons(self) -> bool:
        """Tell whether the plant has reasons for stops, or a stop has one."""
        summed = self.figures.times.by_reason
        return bool(summed) and (
            bool(self.period.reasons) or any(reason.code for reason in summed)
        )

    def stop_name(self, stop: LineStop) -> str:
        """Return the name of a stop."""
        return f'{self.source.extent.history}:{stop.span.seq}'

    @property
    def _lacks_time(self) -> bool:
        """Tell whether time that came twice counts once."""
        return any(step.by_us < 0 for step in self.source.not_taken_out)

    def notes(self) -> tuple[str, ...]:
        """Say what it was made from, and what limits it."""
        when, books = self.period.when, self.books
        span = f'books of {" to ".join(map(when, books.span))}' if books.span else ''
        notes = [*self.source.lines(span)]
        if books.rounded:
            moments = ', '.join(map(when, books.rounded[:_MOST_MOMENTS]))
            more = ' and others' if books.rounded[_MOST_MOMENTS:] else ''
            notes.append(
                'planned time is rounded to whole slots of the books, as the events of these are '
                f'removed: {moments}{more}'
            )
        shown, source, ended = self.figures, self.source, self.source.ended_us
        if ended is not None:
            notes.append(
                f'the journal has no event since {when(ended)}: its last state is taken to go on'
            )
        if shown.lack is not None:
            notes.append(LACKS[shown.lack])
        notes += [
            f'orders waited for {duration(stop.us)}: {stop.detail}'
            for stop in shown.times.stops
            if stop.loss is Loss.ORDERS_WAIT and is_seen(stop.us)
        ]
        if shown.unpaced:
            named = ', '.join(shown.unpaced)
            why = 'does not fit' if self.has_cell else 'is needed: --cell CELL'
            notes.append(f'no performance and no OEE: for the pace of {named} the cell file {why}')
        if shown.times.lacks_causes:
            notes.append(
                'a part of the time is from books of an older program: first-pass yield and MTBF '
                'are not known, and causes of scrap and rework are those of the rest'
            )
        if self.cell_differs:
            notes.append('the pace is by a cell file that is not the one that the node ran with')
        notes += [old_step_words(step, self.period) for step in source.not_taken_out]
        notes += [step_words(step, self.period) for step in source.steps]
        notes += [break_words(pause, self.period) for pause in self.period.changed_breaks]
        if shown.performance is not None and shown.performance > 1 and not self._lacks_time:
            notes.append('faster than the pace: some durations in the cell file are too long')
        scripts = shown.times.scripts
        for made, pace in shown.paces.items():
            if not pace.is_exact:
                notes.append(f'the pace of {scripts[made].name} is no exact one: {pace.period}')
        return tuple(dict.fromkeys(notes))


def account(reading: Reading, period: Period, cell: Cell | None) -> Account:
    """Make the account of a period.

    :param cell: for the pace; None: there is none
    :raises NothingToReport: the period has not begun, or the journal begins after it
    """
    period = period.cut()
    if period.begin_us >= period.end_us:
        begin = f'{period.name} (from {period.when(period.begin_us)})'
        raise NothingToReport(f'the journal has no event of {begin} yet{_reach(reading)}')
    extent = reading.records.extent()
    steady = steady_time(reading)
    period = period.on(steady)
    fold, wanted = fold_with_books(reading, period)
    first, last, newest = 0, 0, wanted.after_seq
    for event in map(steady.of, reading.events(wanted)):
        if us_of(event.time) > period.end_us:
            continue
        newest = event.seq
        if us_of(event.time) >= period.begin_us:
            first, last = first or event.seq, event.seq
        fold.follow(event)
    ended = None if first or fold.books.span else _ended_before(reading, period)
    after = next(reading.events(Wanted(events=FOLLOWED, after_seq=newest)), None)
    if after is not None:
        fold.comes_after(steady.of(after), period.end_us)
    source = Source(extent, first, last, reading.lost, newest, ended)
    return account_of(fold, period, Paces(cell), with_steps(source, reading, period))


def with_steps(source: Source, reading: Reading, period: Period) -> Source:
    """Return a source with the steps of the clock in its period."""
    steady = steady_time(reading)
    begin, end = period.on_clock
    wanted = Wanted(events=(e.ClockStepped.event,), before_seq=steady.since + 1)
    old = (
        Step(event.seq, us_of(event.time), us_of(event.seconds), 0)
        for event in (reading.events(wanted) if steady.since else ())
        if isinstance(event, e.ClockStepped)
    )
    return replace(
        source,
        steps=tuple(steady.within(period.begin_us, period.end_us)),
        not_taken_out=tuple(
            step for step in old if begin <= max(step.times_us) and step.at_us <= end
        ),
    )


def _ended_before(reading: Reading, period: Period) -> int | None:
    """Return when the journal ended, if that was before a period in which no event is.

    :raises NothingToReport: it begins after the period
    """
    try:
        known = whole(reading, '')
    except NothingToReport:
        known = None
    if known is None or period.end_us <= known.begin_us:
        raise NothingToReport(f'the journal has no event of {_span(period)}{_reach(reading)}')
    return known.end_us if known.end_us < period.begin_us else None


def account_of(fold: AccountFold, period: Period, paces: Paces, source: Source) -> Account:
    """Return the account of a period as far as a fold has come, to its end."""
    times, cell = fold.until(period.end_us), paces.cell
    named = digest(cell) if cell is not None else ''
    return Account(
        replace(period, planned=times.planned),
        figures(times, paces, period.micro_stop_us),
        source.beside(fold.books.seqs),
        fold.books,
        cell is not None,
        bool(named) and any(cell_digest != named for cell_digest in times.cells),
    )


def of_job(reading: Reading, job: str, journal: str) -> Period:
    """Return the period of a job: from its start to its end, or to the last event.

    :raises NothingToReport: it has none
    """
    begin = end = None
    for event in reading.events(Wanted(job=job, events=_OF_A_JOB)):
        if isinstance(event, e.JobStarted):
            begin = event
        else:
            end = event
    if begin is None:
        return _by_summary(reading, job, journal)
    steady = steady_time(reading)
    until = whole(reading, journal).end_us if end is None else steady.us(end)
    return Period.all_planned(f'job {job}', steady.us(begin), until, steady)


def _by_summary(reading: Reading, job: str, journal: str) -> Period:
    """Return the period of a job whose events are removed, if there are books of it.

    :raises NothingToReport: there are none
    """
    known = next((summary for summary in reading.summaries() if summary.job == job), None)
    if known is not None and known.started is not None and known.ended is not None:
        steady = steady_time(reading)
        moments = [us_of(known.started), us_of(known.ended)]
        shown = Planned.of(steady.when_shown((moment, moment + 1) for moment in moments)).pieces
        begin, end = shown[0][0], shown[-1][1] - 1
        if next(booked(reading, begin, end), None) is not None:
            return Period.all_planned(f'job {job}', begin, end, steady)
    why = 'knows no start of' if known is None else 'keeps only a summary of'
    raise NothingToReport(f'{journal} {why} job {job}; history --job {job} shows what it has')


def whole(reading: Reading, journal: str) -> Period:
    """Return the period from the first slot of the books, or event that is kept, to the last.

    :raises NothingToReport: there is none
    """
    events = (list(reading.each(Wanted(newest_first=newest), 1)) for newest in (False, True))
    steady = steady_time(reading)
    known = [_moment(record, steady) for records in events for record in records]
    first, last = first_booked(reading), last_booked(reading)
    begins = [] if first is None else [first.begin_us]
    ends = [] if last is None else [last.until_us]
    moments = [*known, *begins, *ends]
    if not moments:
        raise NothingToReport(f'{journal} has no event; name the journal of a node that ran')
    return Period.all_planned('all that the journal has', min(moments), max(moments), steady)


def _moment(record: Record, steady: SteadyTime) -> int:
    return us_of(json.loads(record.text)['time']) - steady.ahead_of(record.seq)


def _span(period: Period) -> str:
    return f'{period.name} ({period.when(period.begin_us)} to {period.when(period.end_us)})'


def _reach(reading: Reading) -> str:
    try:
        known = whole(reading, '')
    except NothingToReport:
        return ': it has none at all; name that of a node that ran'
    reach = f'from {known.when(known.begin_us)} to {known.when(known.end_us)}'
    return f'; it has events {reach}; choose a time in that'
