"""The list of alarms: each is true by the events of the journal."""

from __future__ import annotations

import csv
import io
from datetime import timezone

import pytest
from fakes.day import Day, at
from fakes.hand_made_shift import the_day

from bt_orchestrator.model import events as e
from bt_orchestrator.view.report.account.steady_time import SteadyTime
from bt_orchestrator.view.report.alarms import (
    Alarm,
    AlarmFold,
    Kind,
    Often,
    alarm_lines,
    alarm_plain,
    alarms_of,
    often,
    write_alarms_csv,
)
from bt_orchestrator.view.report.reading import Reading

MIN = 60 * 1_000_000


def of(day: Day) -> AlarmFold:
    return alarms_of(Reading(day.records()))


def held(fold: AlarmFold, number: str) -> Alarm:
    (alarm,) = (entry for entry in fold.alarms if (entry.kind, entry.key) == (Kind.HOLD, number))
    return alarm


def refused(who: str, command: str = 'start', message: str = 'the cell is Held') -> e.Event:
    return e.OperatorRefused(who=who, reason='', command=command, message=message)


def test_hold_alarm_lasts_as_long_as_hold() -> None:
    fold, events = of(the_day()), the_day().events
    raised = {entry.hold: entry.time for entry in events if isinstance(entry, e.HoldRaised)}
    released = {entry.hold: entry.time for entry in events if isinstance(entry, e.HoldReleased)}
    holds = [entry for entry in fold.alarms if entry.kind is Kind.HOLD]
    assert {entry.key: entry.raised_at for entry in holds} == raised
    assert {entry.key: entry.cleared_at for entry in holds} == released
    assert [entry.lasted_us(0) // MIN for entry in holds] == [20, 10, 10, 2]


def test_events_that_are_not_read_change_nothing() -> None:
    day = the_day()
    fold = AlarmFold(SteadyTime())
    for event in day.events:
        fold.follow(event)
    assert fold.alarms == of(day).alarms


def test_alarm_has_its_answer_and_remarks() -> None:
    fold = of(the_day())
    jam = held(fold, '1')
    assert (jam.answer, jam.who, jam.why) == ('retry', 'ann', 'cleared the jam')
    assert jam.answered_at == at('07:20')
    assert jam.remarks == ['ann: called the fitter']
    assert (jam.acknowledged_at, jam.reason, jam.component) == (None, 'aborted', 'a2')
    pause = held(fold, '2')
    assert (pause.answer, pause.who, pause.why) == ('resume', 'ann', 'back')
    doubt = held(fold, '9')
    assert (doubt.answer, doubt.who) == ('clear', 'ann')


def test_first_acknowledgement_counts_and_answers_nothing() -> None:
    day = Day()
    day.note('07:00', e.HoldRaised(hold='1', reason='aborted', message='jam', component='a2'))
    day.note('07:01', e.OperatorDecided(answer='acknowledge', who='ann', reason='', hold='1'))
    day.note('07:02', e.OperatorDecided(answer='acknowledge', who='bob', reason='me', hold='1'))
    alarm = held(of(day), '1')
    assert (alarm.acknowledged_at, alarm.acknowledged_by) == (at('07:01'), 'ann')
    assert (alarm.answered_at, alarm.cleared_at, alarm.remarks) == (None, None, ['bob: me'])


def test_an_abort_stands_until_clear() -> None:
    (alarm,) = (entry for entry in of(the_day()).alarms if entry.kind is Kind.EMERGENCY)
    assert (alarm.raised_at, alarm.cleared_at) == (at('12:00'), at('12:10'))
    assert (alarm.answer, alarm.who) == ('clear', 'ann')


def test_components_that_are_contested_or_silent() -> None:
    day = Day()
    day.note('07:00', e.ComponentContested(component='a2', servers=('/one', '/two')))
    day.note('07:05', e.ComponentContested(component='a2', servers=('/one', '/two', '/three')))
    day.note('07:10', e.ComponentContested(component='a2'))
    day.note('07:20', e.ComponentStateChanged(component='a1', ready=False, value=None))
    contest, silent = of(day).alarms
    assert (contest.kind, contest.component, contest.words) == (Kind.CONTEST, 'a2', '/one, /two')
    assert (contest.raised_at, contest.cleared_at) == (at('07:00'), at('07:10'))
    assert (silent.kind, silent.component, silent.cleared_at) == (Kind.SILENT, 'a1', None)
    day.note('07:21', e.ComponentStateChanged(component='a1', ready=False, value='EMPTY'))
    assert of(day).alarms[1].cleared_at == at('07:21')


def test_refused_commands_clear_at_once_and_are_counted() -> None:
    day = Day()
    day.note('07:00', refused('bob'), refused('eve'), refused('eve', 'abort_job'))
    day.note('07:01', e.RequestRefused(who='eve', count=7, since=at('07:00'), message='too many'))
    fold = of(day)
    assert [(alarm.key, alarm.who, alarm.count) for alarm in fold.alarms] == [
        ('start', 'bob', 1),
        ('start', 'eve', 1),
        ('abort_job', 'eve', 1),
        ('...', 'eve', 7),
    ]
    assert all(alarm.cleared_at == alarm.raised_at for alarm in fold.alarms)
    assert often(fold.alarms, fold.now_us)[:2] == [
        Often('refused', '...', '', 7, 0),
        Often('refused', 'start', '', 2, 0),
    ]


def test_clock_set_back_shortens_no_alarm() -> None:
    day = Day()
    day.note('07:00', e.HoldRaised(hold='1', reason='aborted'))
    day.note('06:10', e.ClockStepped(seconds=-3600.0))
    day.note('06:20', e.HoldReleased(hold='1'))
    alarm = held(of(day), '1')
    assert (alarm.raised_at, alarm.cleared_at) == (at('07:00'), at('06:20'))
    assert alarm.lasted_us(0) == 20 * MIN


def test_alarms_are_counted_by_component_and_reason() -> None:
    day = Day()
    for number, component in enumerate(('a2', 'a1', 'a2')):
        day.note(
            at('07:00') + number * 60,
            e.HoldRaised(hold=str(number), reason='aborted', component=component),
        )
        day.note(at('07:00') + number * 60 + 30, e.HoldReleased(hold=str(number)))
    fold = of(day)
    assert often(fold.alarms, fold.now_us) == [
        Often('hold', 'a2', 'aborted', 2, MIN),
        Often('hold', 'a1', 'aborted', 1, MIN // 2),
    ]


def test_alarm_list_begins_with_newest_alarm() -> None:
    fold = of(the_day())
    lines = list(alarm_lines(fold.alarms, fold.now_us, timezone.utc))
    assert lines[0] == (
        '2026-05-18 13:10:00 to 2026-05-18 13:12:00, 0:02:00  hold: restarted (1 job)'
    )
    assert lines[1] == '  resume by ann 2026-05-18 13:12:00: looked at it'


@pytest.mark.parametrize('number', ['1', '9'])
def test_the_table_has_what_json_has(number: str) -> None:
    fold, file = of(the_day()), io.StringIO()
    write_alarms_csv(fold.alarms, fold.now_us, file)
    file.seek(0)
    rows = {(row['kind'], row['key']): row for row in csv.DictReader(file)}
    plain = alarm_plain(held(fold, number), fold.now_us)
    csv_row = rows['hold', number]
    assert float(csv_row['seconds']) == plain['seconds']
    assert (csv_row['answer'], csv_row['who']) == (plain['answer'], plain['who'])
    assert set(csv_row) == set(plain)
