"""A job of a journal beside its forecast: a virtual run from the moment at which it started.

The run begins with the state that the journal has of that moment, as the forecasts of a running
node begin with the state of now. What is compared sees the events before it, and then either those
of the run or those that really happened.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import replace
from datetime import datetime
from typing import NamedTuple

from bt_orchestrator.base.errors import NotKept, OrchestratorError
from bt_orchestrator.engine.runtime.observed_durations import ObservedDurations
from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.hold_words import hold_words
from bt_orchestrator.model.keeping.records import Wanted
from bt_orchestrator.model.keeping.snapshot import state_to_plain
from bt_orchestrator.model.state import CellState
from bt_orchestrator.ports import ActionTypes, EventSink
from bt_orchestrator.sim.run_on import RunOn
from bt_orchestrator.view.report.account.beginning import fold_at
from bt_orchestrator.view.report.account.booked import steady_time
from bt_orchestrator.view.report.account.fold import AccountFold
from bt_orchestrator.view.report.account.period import Period
from bt_orchestrator.view.report.account.planned import US, us_of
from bt_orchestrator.view.report.past_state import state_at
from bt_orchestrator.view.report.reading import Reading
from bt_orchestrator.view.report.retrospect.retrospect import CourseFold, Retrospect

LOOK_BACK_US = 3600 * US
"""A task at work when the job starts is found if it began within this time before."""

DURATIONS_FROM = 20_000
"""Events before the start from which usual durations are learned."""

_LONG_US = 100 * 366 * 24 * 3600 * US
_OF_A_JOB = (e.JobStarted.event, e.JobCompleted.event, e.JobAborted.event)


class NoForecast(OrchestratorError):
    """A job has no forecast that it could be compared with."""


class Watchers(NamedTuple):
    """Outputs that see the same past, and then the one or the other events."""

    forecast: Sequence[EventSink] = ()
    real: Sequence[EventSink] = ()


NOBODY = Watchers()


class _Span(NamedTuple):
    """The job in the journal, in steady time."""

    job: str
    start: e.JobStarted
    begin_us: int
    end_us: int
    """Its end, or the last event."""
    has_ended: bool
    ahead_us: int
    """How far the clock was ahead when it started. The virtual run has this clock."""

    @property
    def known_us(self) -> float:
        """Up to when the job can be compared with its forecast."""
        return math.inf if self.has_ended else self.end_us


class LookingBack:
    """Looks back at jobs of a journal."""

    def __init__(self, reading: Reading, cell: Cell, types: ActionTypes, name: str) -> None:
        """Look back.

        :param cell: as its file said at that time; its durations are those of the forecasts
        :param name: the journal in messages
        """
        self._reading = reading
        self._steady = steady_time(reading)
        self._cell = cell
        self._types = types
        self._name = name

    def at(self, job: str, watchers: Watchers = NOBODY, *, usual: bool = False) -> Retrospect:
        """Compare a job with its forecast.

        :param usual: tasks take as long as they had taken before; else as the cell file says
        :raises NoForecast: the job did not start, or the run ends before the job does
        :raises NotKept: that moment is not in the journal, or it was another cell then
        """
        span = self._span(job)
        state = state_at(self._reading.records, self._cell, span.start.seq - 1)
        _refuse_unfit(state)
        forecast = CourseFold(job, span.begin_us, self._account(span), span.known_us)
        real = CourseFold(job, span.begin_us, self._account(span))
        shown = [_Shifted(watcher, span.ahead_us) for watcher in watchers.real]
        for event in self._events(span):
            forecast.before(event)
            real.before(event)
            _hand(
                event,
                (*(_Shifted(watcher, span.ahead_us) for watcher in watchers.forecast), *shown),
            )
        durations = self._usual_s(span) if usual else {}
        sinks = (_Shifted(forecast, -span.ahead_us), *watchers.forecast)
        forecast_end_us = self._run(span, state, durations, sinks) - span.ahead_us
        self._follow(span, forecast_end_us, (real, *shown))
        return Retrospect(
            job,
            span.begin_us,
            span.start.seq,
            forecast.course(forecast_end_us),
            real.course(span.end_us),
            usual,
            state.cell_digest != digest(self._cell),
            self._steady.up_to(span.start.seq),
        )

    # --- what happened ----------------------------------------------------------------------

    def _span(self, job: str) -> _Span:
        """Find the job.

        :raises NoForecast: it has not started, or its start is not kept any more
        """
        events = list(self._reading.events(Wanted(job=job, events=_OF_A_JOB)))
        start = next((event for event in events if isinstance(event, e.JobStarted)), None)
        if start is None:
            raise NoForecast(
                f'{self._name} knows no start of job {job}: history --job {job} shows what it has'
            )
        last = events[-1]
        has_ended = last is not start
        if not has_ended:
            last = self._reading.first(Wanted(newest_first=True)) or start
        begin_us, end_us = self._steady.us(start), self._steady.us(last)
        ahead_us = self._steady.ahead_of(start.seq)
        return _Span(job, start, begin_us, end_us, has_ended, ahead_us)

    def _account(self, span: _Span) -> AccountFold:
        """Return an account that has taken in every event before the start."""
        begin_us = span.begin_us
        period = Period.all_planned(span.job, begin_us, begin_us + _LONG_US, self._steady)
        fold, wanted = fold_at(self._reading, period)
        for event in self._read(replace(wanted, before_seq=span.start.seq)):
            fold.follow(event)
        return fold

    def _events(self, span: _Span) -> Iterator[e.Event]:
        """Yield the events of a while before the start."""
        first_us, _ = self._steady.clock_span(span.begin_us - LOOK_BACK_US, span.begin_us)
        yield from self._read(Wanted(since=first_us / US, before_seq=span.start.seq))

    def _read(self, wanted: Wanted) -> Iterator[e.Event]:
        """Yield events in steady time."""
        return map(self._steady.of, self._reading.events(wanted))

    def _usual_s(self, span: _Span) -> Mapping[str, Mapping[str, float]]:
        observed = ObservedDurations()
        first = max(0, span.start.seq - 1 - DURATIONS_FROM)
        for event in self._reading.events(Wanted(first, before_seq=span.start.seq)):
            observed.publish([event])
        return observed.seconds()

    def _follow(self, span: _Span, forecast_end_us: int, sinks: Sequence[EventSink]) -> None:
        """Hand out what happened, as far as the longer of both goes."""
        until_us = max(span.end_us, forecast_end_us)
        _, last_us = self._steady.clock_span(span.begin_us, until_us)
        until = (last_us + 0.5) / US  # times are rounded
        for event in self._read(Wanted(span.start.seq - 1, until=until)):
            if us_of(event.time) <= until_us:
                _hand(event, sinks)

    # --- the forecast -----------------------------------------------------------------------

    def _run(
        self,
        span: _Span,
        state: CellState,
        observed_s: Mapping[str, Mapping[str, float]],
        sinks: Sequence[EventSink],
    ) -> int:
        """Run the job and return when it ended.

        :raises NoForecast: the run ends before the job does
        """
        plain, begin_s = state_to_plain(state), span.start.time
        run = RunOn(self._cell, self._types, plain, observed_s, begin_s, sinks)
        with closing(run):
            end_s = run.go_on_to_end_of(span.job)
            if end_s is None:
                raise NoForecast(_why_none(span, run))
        return us_of(end_s)


def _refuse_unfit(state: CellState) -> None:
    """Refuse a cell that is not the one that jobs were queued for.

    :raises NotKept: it is another one, in more than its durations
    """
    cell = state.cell
    places = {place for script in state.scripts.values() for place in script.places_of_work}
    for component, section in places:
        if component not in cell.components or (section or 0) > cell.conveyor.sections:
            raise NotKept(
                f'the journal does not fit cell {cell.name}, which has no {component} in section '
                f'{section}: name the cell file as it was then'
            )


def _why_none(span: _Span, run: RunOn) -> str:
    holds = [hold_words(hold) for hold in run.state.holds.values()]
    why = f'a person has to answer: {"; ".join(holds)}' if holds else 'nothing can start any more'
    when = datetime.fromtimestamp(run.state.time).isoformat(' ', 'seconds')
    return f'job {span.job} has no forecast: at {when} of the virtual run {why}'


class _Shifted:
    """Hands events to an output, with their time shifted. Implements `ports.EventSink`."""

    def __init__(self, sink: EventSink, by_us: int) -> None:
        self._sink = sink
        self._by_s = by_us / US

    def publish(self, events: Sequence[e.Event]) -> None:
        if self._by_s:
            events = [event.stamped(event.seq, event.time + self._by_s) for event in events]
        self._sink.publish(events)


def _hand(event: e.Event, sinks: Sequence[EventSink]) -> None:
    for sink in sinks:
        sink.publish([event])
