"""Reasons of stops in the account: joined when it is read, also long after retention."""

from __future__ import annotations

from collections import Counter
from contextlib import closing
from dataclasses import replace
from datetime import datetime, timezone
from io import StringIO
from pathlib import Path
from random import Random
from typing import Any

import pytest
from fakes.classified import with_codes
from fakes.day import Day
from fakes.drawn.lines import lines
from fakes.drawn.plan import Plan
from fakes.hand_made_shift import LINE, SCRIPT, started, stopped, succeeded, to
from fakes.kept_books import book_all, whole_fold
from fakes.naive_account import naive_code, naive_stops
from fakes.plan_operator import operate
from fakes.plan_runs import ProductBench
from fakes.profiles import examples
from hypothesis import given
from hypothesis import strategies as st

from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import digest, from_record
from bt_orchestrator.model.plant.shifts import PlantReason
from bt_orchestrator.ports import Snapshot
from bt_orchestrator.store.sqlite.records import SqliteRecords
from bt_orchestrator.store.sqlite.store import SqliteStore
from bt_orchestrator.view.drawing.account.beside_page import beside_page
from bt_orchestrator.view.drawing.account.page import account_page
from bt_orchestrator.view.report.account.account import Account, account, whole
from bt_orchestrator.view.report.account.bookkeeper import has_stop
from bt_orchestrator.view.report.account.course import FOLLOWED
from bt_orchestrator.view.report.account.plain import account_plain, write_csv
from bt_orchestrator.view.report.account.planned import Planned, us_of
from bt_orchestrator.view.report.account.text import account_text
from bt_orchestrator.view.report.beside import beside
from bt_orchestrator.view.report.beside_words import beside_plain, beside_text
from bt_orchestrator.view.report.line_stops import shares
from bt_orchestrator.view.report.reading import Reading

REASONS = {
    'JAM': PlantReason('JAM', {'de': 'Stau', 'en': 'material jam'}, 'material'),
    'LUNCH': PlantReason('LUNCH', {'en': 'lunch'}),
}
MINUTE = 60.0


def decided(answer: str, code: str = '', **about: Any) -> e.Event:
    return e.OperatorDecided(answer=answer, who='ann', reason='so', code=code, **about)


def held(number: str, reason: str = 'aborted') -> e.Event:
    return e.HoldRaised(
        hold=number, job='J', section=2, item='J/1', task='work', name='TASK_A', component='a2',
        attempt=1, attempts=1, reason=reason,
    )  # fmt: skip


def the_day() -> Day:
    """Return a day with a stop for each way to give a reason, and some without."""
    day = Day()
    day.note('05:50', e.OrchestratorStarted(cell='test_line', digest=digest(LINE.cell)))
    loaded = e.ScriptLoaded(script='test', digest=digest(SCRIPT), definition=SCRIPT)
    queued = e.JobQueued(job='J', script='test', digest=digest(SCRIPT), quantity=2000)
    day.note('06:00', loaded, queued, to('Resetting'), to('Idle'), to('Starting'), to('Execute'))
    day.note('06:00', e.JobStarted(job='J'), started('work', 'a2'))
    for hold, begin, end, code in (('1', '06:10', '06:20', 'JAM'), ('2', '06:30', '06:35', '')):
        day.note(begin, held(hold), stopped('own_fault'), to('Holding'), to('Held'))
        day.note(end, decided('retry', code, hold=hold), e.HoldReleased(hold=hold))
        day.note(end, stopped(''), to('Unholding'), to('Execute'))
    paused = e.HoldRaised(hold='3', reason='paused', message='ann: lunch', owner='ann')
    day.note('06:40', decided('pause', 'LUNCH'), paused, stopped('operator'), to('Held'))
    day.note('06:43', decided('resume'), e.HoldReleased(hold='3'), stopped(''), to('Execute'))
    day.note('06:50', decided('stop'), to('Stopping'), stopped('operator', 'stopped'))
    day.note('06:51', to('Stopped'))
    day.note('06:52', decided('stop', 'JAM'))
    day.note('06:54', decided('start'), stopped(''), to('Starting'), to('Execute'))
    gone = e.ComponentOutOfService(component='a2', reason='ann', jobs=())
    day.note('07:00', decided('out_of_service', 'LUNCH', component='a2'), gone, succeeded('work'))
    back = e.ComponentInService(component='a2')
    day.note('07:02', decided('in_service', component='a2'), back, started('more', 'a2'))
    # the node is killed, and starts again
    day.note('07:20', e.OrchestratorStarted(cell='test_line', digest=digest(LINE.cell)))
    day.note('07:30', succeeded('more'), e.JobCompleted(job='J'))
    return day


def seq_of(day: Day, hold: str) -> int:
    """Return the number of the event with which a hold stops the line: its stop reason."""
    raised = (row.seq for row in day.events if isinstance(row, e.HoldRaised) and row.hold == hold)
    return next(raised) + 1


def classify(day: Day, stop: int, code: str) -> None:
    day.note('07:40', decided('classify', code, stop=f'x:{stop}'))


def told(path: Path) -> Account:
    with closing(SqliteRecords(path)) as records:
        reading = Reading(records, pytest.fail)
        return account(reading, replace(whole(reading, 'J'), reasons=REASONS), None)


def written(path: Path, day: Day, *, before: int = 0) -> Account:
    """Return the account of a day, with books in place of the events before one."""
    with closing(SqliteStore(path, synchronous='NORMAL')) as store:
        store.append(day.events)
        if before:
            book_all(store, path)
            store.begin_with(Snapshot(before, '', '{}'))
            while store.remove_batch(before):
                pass
    return told(path)


def codes(made: Account) -> dict[str, Any]:
    """Return the code of each stop, by its loss and its hold."""
    stops = account_plain(made)['line_stops']
    return {f'{stop["loss"]} {stop["hold"] or ""}'.strip(): stop['code'] for stop in stops}


def test_7_10_each_way_to_give_a_reason(tmp_path: Path) -> None:
    made = written(tmp_path / 'j', the_day())
    assert codes(made) == {
        'own_fault 1': 'JAM',
        'own_fault 2': None,
        'operator 3': 'LUNCH',
        'operator': 'JAM',
        'waiting': 'LUNCH',
        'no_node': None,
    }
    plain = account_plain(made)
    times = {reason['code']: (reason['times'], reason['seconds']) for reason in plain['reasons']}
    assert times == {
        'JAM': (2, 14 * MINUTE),
        'LUNCH': (2, 5 * MINUTE),
        None: (2, 23 * MINUTE),  # hold 2, and 18 minutes without a node
    }
    assert plain['line_stops_all']['seconds'] == 42 * MINUTE
    assert plain['not_classified'] == round(23 / 42, 6)
    assert plain['reasons'][1]['words'] == {'de': 'Stau', 'en': 'material jam'}


def test_7_10_a_code_is_of_its_own_stop_alone(tmp_path: Path) -> None:
    day, queued = the_day(), e.JobQueued(
        job='K', script='test', digest=digest(SCRIPT), quantity=5
    )  # fmt: skip
    day.note('07:32', queued, e.JobStarted(job='K'), started('more', 'a2'))
    # the reason of a stop comes in a later quarter of an hour, and ends with the start
    day.note('07:40', decided('stop'), to('Stopping'), stopped('operator', 'stopped'))
    day.note('08:05', decided('stop', 'JAM'))
    day.note('08:10', decided('start'), stopped(''), to('Starting'), to('Execute'))
    day.note('08:20', to('Stopping'), stopped('operator', 'stopped after an item'))
    day.note('08:30', decided('start'), stopped(''), to('Starting'), to('Execute'))
    # a hold that an answer leaves, and a pause that is given another reason at its end
    day.note('08:40', held('5'), stopped('own_fault'), to('Held'))
    day.note('08:42', decided('abort_job', 'JAM', hold='5'))
    day.note('08:44', decided('retry', 'LUNCH', hold='5'), e.HoldReleased(hold='5'))
    day.note('08:44', stopped(''), to('Execute'))
    paused = e.HoldRaised(hold='6', reason='paused', owner='ann')
    day.note('08:50', decided('pause', 'LUNCH'), paused, stopped('operator'), to('Held'))
    day.note('08:55', decided('resume', 'JAM', hold='6'), e.HoldReleased(hold='6'))
    day.note('08:55', stopped(''), to('Execute'), succeeded('more'))
    # a component that was out of service, and a job that was paused before
    silent = e.ComponentStateChanged(component='a2', ready=False, value='')
    day.note('08:56', silent)
    day.note('09:00', decided('pause', 'JAM', job='K'), e.JobPaused(job='K'))
    day.note('09:05', decided('resume', job='K'), e.JobResumed(job='K'))
    day.note('09:10', decided('pause', job='K'), e.JobPaused(job='K'))
    day.note('09:15', decided('resume', job='K'), e.JobResumed(job='K'))
    stops = account_plain(written(tmp_path / 'j', day))['line_stops']
    begins = (datetime.fromisoformat(stop['from']).astimezone(timezone.utc) for stop in stops)
    actual = {f'{moment:%H:%M}': stop['code'] for moment, stop in zip(begins, stops, strict=True)}
    expected = {'07:40': 'JAM', '08:20': None, '08:40': 'LUNCH', '08:50': 'JAM'}
    expected |= {'08:56': None, '09:00': 'JAM', '09:10': None}
    assert {begin: actual.get(begin, 'no stop') for begin in expected} == expected


def test_7_10_pause_explained_afterwards_has_one_reason(
    tmp_path: Path,
) -> None:
    """One press pauses; the pause with a reason takes its place, and `resume` names the first."""
    day = the_day()
    raised = [e.HoldRaised(hold=number, reason='paused', owner='ann') for number in ('8', '9')]
    queued = e.JobQueued(job='K', script='test', digest=digest(SCRIPT), quantity=5)
    day.note('07:32', queued, e.JobStarted(job='K'), started('more', 'a2'))
    day.note('07:34', decided('pause'), raised[0], stopped('operator'), to('Held'))
    day.note('07:35', decided('pause', 'LUNCH'), raised[1])
    day.note('07:35', decided('resume', 'LUNCH', hold='8'), e.HoldReleased(hold='8'))
    day.note('07:39', decided('resume'), e.HoldReleased(hold='9'), stopped(''), to('Execute'))
    actual = codes(written(tmp_path / 'j', day))
    assert (actual['operator 8'], actual['operator 9']) == ('LUNCH', 'LUNCH')


def test_7_10_later_classification_changes_reasons_only(tmp_path: Path) -> None:
    before, day = written(tmp_path / 'before', the_day()), the_day()
    named = {stop.span.hold: stop.span.seq for stop in before.figures.times.line_stops}
    assert (named['1'], named['2']) == (seq_of(day, '1'), seq_of(day, '2'))
    for hold, code in (('1', 'JAM'), ('1', 'LUNCH'), ('2', 'LUNCH'), ('2', 'JAM')):
        classify(day, named[hold], code)
    after = written(tmp_path / 'after', day)
    assert codes(after) == {**codes(before), 'own_fault 1': 'LUNCH', 'own_fault 2': 'JAM'}
    shown, was = after.figures.times, before.figures.times
    assert [stop[:2] for stop in shown.line_stops] == [stop[:2] for stop in was.line_stops]
    assert [cause for cause in shown.stops if cause.is_shown] == [
        cause for cause in was.stops if cause.is_shown
    ]
    assert after.figures.availability == before.figures.availability


def test_7_10_reasons_survive_retention_beside_the_books(tmp_path: Path) -> None:
    day = the_day()
    classify(day, seq_of(day, '2'), 'LUNCH')
    day.note('08:00', e.JobHeld(job='Z'))
    last = day.events[-1].seq
    with_events = written(tmp_path / 'with', day)
    with_books = written(tmp_path / 'books', day, before=last)
    assert with_books.source.extent.first_seq == last
    assert codes(with_events)['own_fault 2'] == 'LUNCH'
    assert with_books.figures.times.by_reason == with_events.figures.times.by_reason
    given = [stop.reason for stop in with_events.figures.times.line_stops]
    assert [stop.reason for stop in with_books.figures.times.line_stops] == given


@pytest.mark.parametrize('is_booked', [False, True])
def test_7_10_a_stop_is_known_by_its_name(tmp_path: Path, *, is_booked: bool) -> None:
    day, path = the_day(), tmp_path / 'j'
    day.note('08:00', e.JobHeld(job='Z'))
    made = written(path, day, before=day.events[-1].seq if is_booked else 0)
    names = {stop.span.seq for stop in made.figures.times.line_stops}
    now = day.events[-1].time + 60.0
    with closing(SqliteRecords(path)) as records:
        known = {seq for seq in range(1, 100) if has_stop(records, seq, now, pytest.fail)}
    assert known == names
    assert len(names) == 6


@examples(3, 300)
@given(lines(), st.randoms(use_true_random=False))
def test_7_10_drawn_runs_match_the_naive_reasons(plan: Plan, random: Random) -> None:
    bench = ProductBench(plan)
    operate(bench, plan.moments)
    if not bench.run.records:
        return
    records = with_codes(bench.run.records, random)
    events = [from_record(entry) for entry in records]
    begin, end = us_of(events[0].time), us_of(events[-1].time) + 1
    planned = Planned.of([(begin, end)])
    fold = whole_fold(planned, events)
    for event in events:
        if event.event in FOLLOWED:
            fold.follow(event)
    times = fold.until(end)
    mine = {stop.span.seq: stop.reason for stop in times.line_stops}
    naive = naive_stops(records, planned.pieces)
    assert list(mine) == [stop.seq for stop in naive]
    for stop in naive:
        reason = mine[stop.seq]
        assert (reason.code if reason is not None else '') == naive_code(stop, records), stop
    known = Counter(stop.reason.code if stop.reason else '' for stop in times.line_stops)
    summed = Counter({entry.code: entry.times for entry in shares(times.by_reason)})
    assert summed == known


def test_days_side_by_side_name_reasons_of_losses(tmp_path: Path) -> None:
    period = written(tmp_path / 'j', the_day()).period
    half = (period.begin_us + period.end_us) // 2
    halves = [
        replace(period, begin_us=begin, end_us=end, planned=Planned.of([(begin, end)]))
        for begin, end in ((period.begin_us, half), (half, period.end_us))
    ]
    with closing(SqliteRecords(tmp_path / 'j')) as records:
        report = beside(Reading(records, pytest.fail), [('a', halves[0]), ('b', halves[1])], None)
    largest = {row['loss']: row['reasons'] for row in beside_plain(report, None)['largest_losses']}
    assert largest['own_fault'] == [
        {'code': 'JAM', 'times': 1, 'seconds': 10 * MINUTE},
        {'code': None, 'times': 1, 'seconds': 5 * MINUTE},
    ]
    assert largest['no_node'] == []
    words = 'reason material jam: 0:10:00 in 1'
    assert words in '\n'.join(beside_text(report, None))
    assert words in beside_page(report, None)


def test_a_report_tells_reasons_in_words(tmp_path: Path) -> None:
    made, table = written(tmp_path / 'j', the_day()), StringIO()
    text = '\n'.join(account_text(made))
    assert 'stops by reason, 54.8 % of their time not classified:' in text
    assert 'material jam' in text
    page = account_page(made)
    assert 'Stops by reason, 54.8 % of their time not classified' in page
    assert 'material jam' in page
    write_csv(made, table)
    assert 'reason,JAM,,material,2,840.0,0.333333,' in table.getvalue()
    without = account_text(replace(made, period=replace(made.period, reasons={})))
    assert 'JAM' in '\n'.join(without)
