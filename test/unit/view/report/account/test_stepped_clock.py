"""A clock that is set: figures keep the time that passed, and reports name the step."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import closing
from datetime import timezone
from pathlib import Path

import pytest
from fakes.day import Day, at
from fakes.hand_made_shift import LINE, SCRIPT, to
from fakes.kept_books import book_all

from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.plant.shifts import Hours, Shift
from bt_orchestrator.ports import Snapshot
from bt_orchestrator.store.sqlite.records import SqliteRecords
from bt_orchestrator.store.sqlite.store import SqliteStore
from bt_orchestrator.view.report.account import booked
from bt_orchestrator.view.report.account.account import Account, account, of_job, whole
from bt_orchestrator.view.report.account.calendar import Now, shift_on
from bt_orchestrator.view.report.account.live import LiveAccount
from bt_orchestrator.view.report.account.losses import Loss
from bt_orchestrator.view.report.account.period import Period
from bt_orchestrator.view.report.account.plain import account_plain
from bt_orchestrator.view.report.account.planned import US, us_of
from bt_orchestrator.view.report.account.steady_time import SteadyTime
from bt_orchestrator.view.report.reading import Reading

NODE = e.OrchestratorStarted(cell='test_line', digest=digest(LINE.cell))
LOADED = e.ScriptLoaded(script='test', digest=digest(SCRIPT), definition=SCRIPT)
QUEUED = e.JobQueued(job='J', script='test', digest=digest(SCRIPT), quantity=9)
DONE = e.JobCompleted(job='J')
BEGUN = (NODE, LOADED, QUEUED, to('Execute'), e.JobStarted(job='J'))
MINUTE = 60 * US


def work(number: int) -> e.TaskStarted:
    return e.TaskStarted(
        job='J', item=f'J/{number}', section=2, task='work', name='TASK_A', action='/a2/do',
        component='a2', attempt=1, goal='', args={},
    )  # fmt: skip


def out(number: int) -> e.ItemRemoved:
    return e.ItemRemoved(job='J', item=f'J/{number}', section=3, how='packed')


def set_back() -> Day:
    """Return a journal whose clock was set back by an hour while a job ran."""
    day = Day()
    day.note('18:03', *BEGUN, work(1))
    day.note('17:10', e.ClockStepped(seconds=-3600.0), out(1))
    day.note('17:14', out(2), DONE)
    return day


def of_all(day: Day) -> Account:
    reading = Reading(day.records())
    return account(reading, whole(reading, 'j'), LINE.cell)


@pytest.mark.parametrize('of', [lambda r: whole(r, 'j'), lambda r: of_job(r, 'J', 'j')])
def test_period_is_as_long_as_time_passed(of: object) -> None:
    assert callable(of)
    reading = Reading(set_back().records())
    period = of(reading)
    assert isinstance(period, Period)
    assert period.end_us - period.begin_us == 11 * MINUTE
    made = account(reading, period, LINE.cell)
    plain = account_plain(made)
    assert plain['period']['planned_s'] == 660.0
    assert plain['quantities']['produced'] == 2
    assert made.figures.times.producing_us == 11 * MINUTE


def test_report_names_clock_step_with_clock_times() -> None:
    notes = of_all(set_back()).notes()
    (named,) = (
        note for note in notes if note.startswith('the clock was set back by 3600 s, from')
    )
    assert named.endswith('the time that it showed twice passed twice, and counts twice')
    assert not any('cell file are too long' in note for note in notes)


def test_earlier_events_count_despite_later_clock_reading() -> None:
    day = Day()
    day.note('08:00', NODE)
    day.note('11:01', e.ClockStepped(seconds=10800.0), *BEGUN[1:], work(1))
    day.note('09:10', e.ClockStepped(seconds=-7200.0), out(1))
    day.note('09:30', out(2), DONE)
    period = Period.all_planned('period', us_of(at('09:20')), us_of(at('09:25')))
    made = account(Reading(day.records()), period, LINE.cell)
    assert made.figures.times.producing_us == 5 * MINUTE


def test_clock_set_forward_adds_no_time() -> None:
    day = Day()
    day.note('08:00', *BEGUN, work(1))
    day.note('11:00', e.ClockStepped(seconds=3600.0))
    day.note('11:30', out(1), DONE)
    made = of_all(day)
    assert made.figures.times.planned.total_us == 150 * MINUTE
    assert made.figures.times.lost_us == {}
    assert any('did not pass, and does not count' in note for note in made.notes())


EARLY = Shift('early', Hours(6 * 60, 14 * 60), (Hours(9 * 60, 9 * 60 + 15),))
LATE = Shift('late', Hours(14 * 60, 22 * 60))


def over_two_shifts() -> Day:
    """Return a journal in which 14:00 came twice: from 13:50 to 14:10, and from 13:55 on."""
    day = Day()
    day.note('13:50', *BEGUN, work(1))
    day.note('14:05', out(1))
    day.note('13:55', e.ClockStepped(seconds=-900.0), out(2))
    day.note('13:58', out(3))
    day.note('14:20', out(4), DONE)
    return day


def of_shift(day: Day, shift: Shift) -> Account:
    period = shift_on(shift, Day.date(), timezone.utc, at('00:00') + 24 * 3600)
    return account(Reading(day.records()), period, LINE.cell)


def test_moment_belongs_to_shift_shown_by_clock() -> None:
    early, late = (of_shift(over_two_shifts(), shift) for shift in (EARLY, LATE))
    assert early.figures.times.producing_us == (10 + 5) * MINUTE
    assert late.figures.times.producing_us == (10 + 20) * MINUTE
    assert (early.figures.produced, late.figures.produced) == (1, 3)
    for shift in (early, late):
        assert any('the clock was set back by 900 s' in note for note in shift.notes())


def test_live_account_of_shift_matches_fresh_account() -> None:
    day = over_two_shifts()
    period = shift_on(EARLY, Day.date(), timezone.utc)
    live = LiveAccount(lambda _: Now(period), None)
    for number in (7, 9, len(day.events)):
        so_far = Day()
        so_far.events = day.events[:number]
        seen = live.look(so_far.records(), so_far.events[-1].time)
        new = LiveAccount(lambda _: Now(period), None)
        fresh = new.look(so_far.records(), so_far.events[-1].time)
        assert seen is not None
        assert fresh is not None
        assert account_plain(seen.account) == account_plain(fresh.account)


def test_clock_behind_at_node_start_was_set_back() -> None:
    day = Day()
    day.note('18:00', *BEGUN, work(1))
    day.note('18:10', out(1))
    day.note('17:30', NODE)
    day.note('17:40', out(2), DONE)
    made = of_all(day)
    assert made.figures.times.planned.total_us == 20 * MINUTE
    assert made.figures.produced == 2
    assert any('was set back by 2400 s' in note for note in made.notes())


@pytest.mark.parametrize(
    ('by_s', 'stepped', 'started'), [(3600.0, '11:10', '11:40'), (-3600.0, '09:10', '09:40')]
)
def test_proven_step_keeps_time_without_node(by_s: float, stepped: str, started: str) -> None:
    day = Day()
    day.note('10:00', *BEGUN, work(1))
    day.note('10:10', out(1))
    day.note(stepped, e.ClockStepped(seconds=by_s))
    day.note(started, NODE)
    made = of_all(day)
    assert made.figures.times.lost_us == {Loss.NO_NODE: 30 * MINUTE}
    assert sum('the clock was set' in note for note in made.notes()) == 1


def test_attempt_over_step_takes_the_time_passed() -> None:
    day = Day()
    day.note('10:00', *BEGUN, work(1))
    day.note('09:10', e.ClockStepped(seconds=-3600.0))
    failed = e.TaskFailed(
        job='J', item='J/1', section=2, task='work', attempt=1, reason='aborted', message=''
    )
    day.note('09:12', failed, DONE)
    (failing,) = of_all(day).figures.times.failing
    assert failing.us == 12 * MINUTE


# --- books of the version before --------------------------------------------------------------


def in_old_books(path: Path, events: Sequence[e.Event], monkeypatch: pytest.MonkeyPatch) -> None:
    """Write events with books as a program wrote them that did not take steps out."""
    with closing(SqliteStore(path)) as store, monkeypatch.context() as older:
        store.append(events)
        older.setattr(SteadyTime, 'of', lambda _, event: event)
        older.setattr(booked, 'BOOKS_VERSION', booked.WITHOUT_STEPS)
        book_all(store, path)


def test_books_of_previous_version_are_read_and_noted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, day = tmp_path / 'journal', set_back()
    in_old_books(path, day.events, monkeypatch)
    day.note('19:00', QUEUED, e.JobStarted(job='J'), work(1))
    day.note('18:30', e.ClockStepped(seconds=-3600.0))
    day.note('19:00', DONE)
    with closing(SqliteStore(path)) as store:
        store.append(day.events[-5:])
        book_all(store, path)
    with closing(SqliteRecords(path)) as records:
        reading = Reading(records)
        made = account(reading, whole(reading, 'j'), LINE.cell)
    times, notes = made.figures.times, made.notes()
    assert made.books.span
    assert sum('the books of that time are of an older program' in note for note in notes) == 1
    assert sum('passed twice, and counts twice' in note for note in notes) == 1
    assert times.producing_us == (7 + 60) * MINUTE, 'but 4 minutes of the first hour'
    assert times.lost_us == {Loss.NO_ORDER: 50 * MINUTE}


def test_restarted_books_keep_earlier_clock_steps(tmp_path: Path) -> None:
    path, day = tmp_path / 'journal', set_back()
    hours = Period.all_planned('hours', us_of(at('17:00')), us_of(at('17:15')))

    def told() -> int:
        with closing(SqliteRecords(path)) as records:
            return account(Reading(records), hours, None).figures.times.producing_us

    with closing(SqliteStore(path)) as store:
        store.append(day.events)
        book_all(store, path)
        expected = told()
        assert expected == 4 * MINUTE
        begun = len(day.events)
        day.note('19:00', QUEUED, e.JobStarted(job='J'), work(1))
        day.note('19:30', DONE)
        store.append(day.events[begun:])
        store.begin_with(Snapshot(begun + 2, '', '{}'))
        while store.remove_batch(begun + 2):
            pass
        book_all(store, path)
    assert told() == expected
