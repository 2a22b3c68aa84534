"""Books of drawn runs: a report by books says the same as one by all the events."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from random import Random

import pytest
from fakes.classified import with_codes
from fakes.drawn.lines import lines
from fakes.drawn.plan import Plan
from fakes.kept_books import book_all, whole_fold
from fakes.plan_operator import operate
from fakes.plan_runs import ProductBench
from fakes.profiles import examples
from fakes.stepped import Steps, drawn_steps, nameless, stepped
from hypothesis import given
from hypothesis import strategies as st

from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import from_record
from bt_orchestrator.model.keeping.records import Wanted
from bt_orchestrator.ports import Snapshot
from bt_orchestrator.store.sqlite.records import SqliteRecords
from bt_orchestrator.store.sqlite.store import SqliteStore
from bt_orchestrator.view.report.account.beginning import fold_at, fold_with_books
from bt_orchestrator.view.report.account.booked import steady_time
from bt_orchestrator.view.report.account.calendar import Now
from bt_orchestrator.view.report.account.fold import FOLLOWED, AccountFold, Times
from bt_orchestrator.view.report.account.live import LiveAccount
from bt_orchestrator.view.report.account.period import Period
from bt_orchestrator.view.report.account.planned import Planned, us_of
from bt_orchestrator.view.report.account.slot import QUARTER_US
from bt_orchestrator.view.report.account.steady_time import SteadyTime
from bt_orchestrator.view.report.reading import Reading

pytestmark = pytest.mark.timeout(24 * 3600)

Beginning = Callable[[Reading, Period], tuple[AccountFold, Wanted]]

MARKS = st.lists(st.integers(0, 24), min_size=4, max_size=4, unique=True).map(sorted)
"""Where planned time begins, breaks, goes on and ends, in 24ths of the run."""


@examples(4, 300)
@given(
    plan=lines(),
    stretch=st.sampled_from([30.0, 97.0, 900.0]),
    marks=MARKS,
    on_slots=st.booleans(),
    share=st.integers(1, 9),
    most=st.sampled_from([7, 40, 100_000]),
    removed=st.integers(0, 9),
    random=st.randoms(use_true_random=False),
)
def test_drawn_runs(
    plan: Plan,
    stretch: float,
    marks: list[int],
    *,
    on_slots: bool,
    share: int,
    most: int,
    removed: int,
    random: Random,
) -> None:
    bench = ProductBench(plan)
    operate(bench, plan.moments)
    events = [_slowly(from_record(element), stretch) for element in bench.run.records]
    if not events:
        return
    period = _period(events, marks, to_slots=on_slots or removed > 0)
    number = sum(us_of(element.time) <= period.end_us for element in events)
    if not number:
        return
    classified = with_codes(bench.run.records[:number], random)
    events = [_slowly(from_record(element), stretch) for element in classified]

    def new_live() -> LiveAccount:
        return LiveAccount(lambda _: Now(period), None)

    with tempfile.TemporaryDirectory() as folder, closing(_Journal(Path(folder))) as journal:
        cut, live = len(events) * share // 10, new_live()
        for part in (events[:cut], events[cut:]):
            if part:
                journal.add(part, most)
                assert journal.live(live, part[-1]) == journal.live(new_live(), part[-1])
        journal.add((), most)
        cut = _at_one_moment(events, cut)
        assert _beside(events, cut, most, period) == _by_events(events, period)
        assert journal.times(period, fold_at) == _by_events(events, period)
        assert journal.times(period) == _by_events(events, period)
        journal.remove(events[-1].seq * removed // 10)
        assert journal.times(period) == _by_events(events, period)
        for element in (live, new_live()):
            assert journal.live(element, None) == _by_events(events, period)


@examples(3, 300)
@given(
    plan=lines(),
    stretch=st.sampled_from([97.0, 900.0]),
    steps=drawn_steps(st.integers(1, 8).map(lambda quarters: quarters * 900.0)),
    marks=MARKS,
    share=st.integers(1, 9),
    most=st.sampled_from([7, 100_000]),
    removed=st.integers(0, 9),
)
def test_books_of_a_clock_that_is_set(
    plan: Plan,
    stretch: float,
    steps: Steps,
    marks: list[int],
    share: int,
    most: int,
    removed: int,
) -> None:
    bench = ProductBench(plan)
    operate(bench, plan.moments)
    run = [_slowly(from_record(entry), stretch) for entry in bench.run.records]
    if not run:
        return
    period = _period(run, marks, to_slots=True)
    events, steady = stepped(run, steps), SteadyTime()
    for event in events:
        steady.follow(event)
    events = [entry for entry in events if steady.us(entry) <= period.end_us]
    if not events:
        return
    kept = [entry for entry in run if us_of(entry.time) <= period.end_us]
    expected = nameless(_by_events(kept, period))
    period = replace(period, steady=steady)
    live = LiveAccount(lambda _: Now(period), None)
    with tempfile.TemporaryDirectory() as folder, closing(_Journal(Path(folder))) as journal:
        cut = len(events) * share // 10
        for part in (events[:cut], events[cut:]):
            if part:
                journal.add(part, most)
                new = LiveAccount(lambda _: Now(period), None)
                assert journal.live(live, part[-1]) == journal.live(new, part[-1])
        for begin in (fold_at, fold_with_books):
            assert nameless(journal.times(period, begin)) == expected
        journal.remove(events[-1].seq * removed // 10)
        assert nameless(journal.times(period)) == expected
        assert nameless(journal.live(live, None)) == expected


def _at_one_moment(events: Sequence[e.Event], near: int) -> int:
    """Return where to part events so that books end at a moment at which more happens."""
    for cut in range(1, len(events)):
        if events[cut - 1].time == events[cut].time and isinstance(events[cut], e.ItemRemoved):
            return cut
    return near


def _beside(events: Sequence[e.Event], cut: int, most: int, period: Period) -> Times:
    """Return the account where the events after some are in no book yet."""
    with tempfile.TemporaryDirectory() as folder, closing(_Journal(Path(folder))) as journal:
        if cut:
            journal.add(events[:cut], most)
        if cut < len(events):
            journal.add(events[cut:], 0)
        return journal.times(period)


def _slowly(event: e.Event, stretch: float) -> e.Event:
    """Return an event of a run that takes so much longer; whole seconds, and moments between."""
    return event.stamped(event.seq, 1000 * 900 + round(event.time * stretch, 1))


def _period(events: Sequence[e.Event], marks: Sequence[int], *, to_slots: bool) -> Period:
    begin, end = us_of(events[0].time), us_of(events[-1].time) + 1_000_000
    moments = [begin + mark * (end - begin) // 24 for mark in marks]
    if to_slots:
        moments = [round(moment / QUARTER_US) * QUARTER_US for moment in moments]
        moments = [moment + number * QUARTER_US for number, moment in enumerate(moments)]
    first, off, on, last = moments
    return Period('drawn', first, last, Planned.of([(first, off), (on, last)]))


def _by_events(events: Sequence[e.Event], period: Period) -> Times:
    fold = whole_fold(period.planned, events)
    for event in events:
        if event.event in FOLLOWED:
            fold.follow(event)
    return fold.until(period.end_us)


OVER_S = 1e10
"""The time after all periods: runs are stretched until they take a year."""


class _Journal:
    """A file whose books are made as it grows."""

    def __init__(self, folder: Path) -> None:
        self._path = folder / 'journal.db'
        self._store = SqliteStore(self._path)

    def add(self, events: Sequence[e.Event], most: int) -> None:
        """Write events, and make books of so many at a time; 0: none."""
        if events:
            self._store.append(events)
        if most:
            book_all(self._store, self._path, most)

    def remove(self, before: int) -> None:
        """Remove events, as retention does."""
        self._store.begin_with(Snapshot(before, '', '{}'))
        while self._store.remove_batch(before):
            pass

    def times(self, period: Period, begin: Beginning = fold_with_books) -> Times:
        with closing(SqliteRecords(self._path)) as records:
            reading = Reading(records, _no_damage)
            fold, wanted = begin(reading, period)
            for event in map(steady_time(reading).of, reading.events(wanted)):
                if us_of(event.time) <= period.end_us:
                    fold.follow(event)
            return fold.until(period.end_us)

    def live(self, account: LiveAccount, newest: e.Event | None) -> Times:
        """Return what an account says that goes on.

        :param newest: its time is now; None: the period is over
        """
        with closing(SqliteRecords(self._path)) as records:
            shown = account.look(records, OVER_S if newest is None else newest.time + 1.0)
            assert shown is not None
            return shown.account.figures.times

    def close(self) -> None:
        self._store.close()


def _no_damage(sentence: str) -> None:
    raise AssertionError(sentence)
