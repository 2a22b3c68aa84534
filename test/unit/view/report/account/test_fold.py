"""What an account does where the journal, the node or the clock is not as usual."""

from __future__ import annotations

import pytest
from fakes.day import Day, at
from fakes.line import THREE, Line

from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import from_record
from bt_orchestrator.view.report.account.account import account, of_job, whole
from bt_orchestrator.view.report.account.fold import AccountFold, Times
from bt_orchestrator.view.report.account.losses import Loss
from bt_orchestrator.view.report.account.planned import US, Planned, us_of
from bt_orchestrator.view.report.account.stops import MOST_HOLDS
from bt_orchestrator.view.report.reading import Reading

NODE = e.OrchestratorStarted(cell='c', digest='d')
ORDER = e.JobQueued(job='J', script='s', digest='d', quantity=1)
GOES = (e.JobStarted(job='J'), e.CellStateChanged(state='Execute', previous='Idle'))
TASK = e.TaskStarted(
    job='J', section=2, item='J/1', task='t', name='T', action='/a', component='a', attempt=1,
    goal='g',
)  # fmt: skip
LEFT = e.JobRemoved(job='Z')
HOLD = e.HoldRaised(hold='1', reason='aborted', component='a', name='T')


def times(day: Day, end: str, *, is_whole: bool = True, begin: str = '06:00') -> Times:
    fold = AccountFold(Planned.of([(us_of(at(begin)), us_of(at(end)))]), is_whole=is_whole)
    for event in day.events:
        fold.follow(event)
    return fold.until(us_of(at(end)))


def minutes(times: Times) -> dict[str, float]:
    lost = {loss.value: us / US / 60 for loss, us in times.lost_us.items()}
    return lost | ({'production': times.producing_us / US / 60} if times.producing_us else {})


def at_work(clock: str = '06:00') -> Day:
    day = Day()
    day.note(clock, NODE, ORDER, *GOES, TASK)
    return day


def test_before_the_first_event_nothing_is_known() -> None:
    assert minutes(times(at_work('06:10'), '06:30')) == {'not_recorded': 10, 'production': 20}


def test_removed_events_leave_time_not_recorded() -> None:
    day = Day(first_seq=900)
    day.note('06:00', ORDER)
    day.note('06:10', *GOES, TASK)
    actual = minutes(times(day, '06:30', is_whole=False))
    assert actual == {'not_recorded': 10, 'production': 20}


@pytest.mark.parametrize(
    ('ends', 'lost'),
    [
        ((), {'no_node': 10, 'production': 20}),
        ((e.OrchestratorStopping(),), {'no_node': 10, 'production': 20}),
        ((e.JobCompleted(job='J'),), {'orders_wait': 20, 'production': 10}),
        (
            (e.JobCompleted(job='J'), LEFT, e.OrchestratorStopping()),
            {'no_order': 20, 'production': 10},
        ),
    ],
)
def test_stopped_node_is_loss_only_with_work(
    ends: tuple[e.Event, ...], lost: dict[str, float]
) -> None:
    day = at_work()
    day.note('06:10', e.JobHeld(job='Z'), *ends)
    day.note('06:20', NODE)
    assert minutes(times(day, '06:30')) == lost


def test_clock_set_forward_leaves_time_not_recorded() -> None:
    day = at_work()
    day.note('06:20', e.ClockStepped(seconds=300.0))
    assert minutes(times(day, '06:30')) == {'production': 25, 'not_recorded': 5}


def test_clock_set_back_books_no_time_twice() -> None:
    day = at_work()
    day.note('06:10', e.ClockStepped(seconds=-600.0))  # 20 minutes have passed
    day.note('06:15', e.StopReasonChanged(stop_reason='operator', reason='x'))
    assert minutes(times(day, '06:30')) == {'production': 20, 'operator': 10}


def test_orders_that_may_not_start_are_no_work() -> None:
    day = Day()
    waits = e.JobQueued(job='W', script='s', digest='d', quantity=1, awaits_start=True)
    lacks = e.JobQueued(job='L', script='s', digest='d', quantity=1, unavailable=('a', 'b'))
    day.note('06:00', NODE, ORDER, waits, lacks, e.JobHeld(job='J'))
    day.note('06:10', e.ComponentInService(component='a'))
    day.note('06:20', e.ComponentInService(component='b'))
    day.note('06:25', e.ComponentOutOfService(component='a', reason='x', jobs=('L',)))
    day.note('06:30', e.JobMayStart(job='W'))
    day.note('06:35', e.JobRemoved(job='W'))
    day.note('06:40', e.JobReleased(job='J'))
    day.note('06:50', e.JobHeld(job='J'))
    booked = times(day, '07:00')
    assert minutes(booked) == {'orders_wait': 40, 'operator': 20}
    assert {stop.detail: stop.us // US // 60 for stop in booked.stops} == {
        'a, b out of service; before its start; held in the queue': 10,
        'b out of service; before its start; held in the queue': 10,
        'a out of service; before its start; held in the queue': 5,
        'a out of service; held in the queue': 15,
        'the cell was Stopped': 20,
    }


def test_jobs_that_an_operator_paused_are_no_wait() -> None:
    day = at_work()
    done = e.TaskSucceeded(job='J', section=2, item='J/1', task='t', attempt=1, goal='g')
    day.note('06:10', e.JobPaused(job='J'), done)
    day.note('06:20', e.JobResumed(job='J'))
    assert minutes(times(day, '06:30')) == {'production': 10, 'operator': 10, 'waiting': 10}


def test_the_oldest_of_several_holds_has_the_time() -> None:
    day = at_work()
    for number, clock in enumerate(('06:10', '06:12'), 1):
        hold = e.HoldRaised(hold=str(number), reason='aborted', component='a', name='T')
        day.note(clock, hold, e.StopReasonChanged(stop_reason='own_fault'))
    day.note('06:15', e.HoldReleased(hold='1'))
    day.note('06:20', e.HoldReleased(hold='2'), e.StopReasonChanged(stop_reason=''))
    booked = times(day, '06:30')
    assert [(held.hold, held.lost_us / US / 60) for held in booked.holds] == [('1', 5), ('2', 5)]
    assert [held.stood_us / US / 60 for held in booked.holds] == [5, 8]
    (stop,) = booked.stops
    assert (stop.times, stop.us / US / 60) == (2, 10)


def test_costliest_holds_are_listed_others_summed_up() -> None:
    day, begin = at_work(), at('06:00')
    number = MOST_HOLDS + 20
    for n in range(1, number + 1):
        begun = begin + 200.0 * n
        hold = e.HoldRaised(hold=str(n), reason='aborted', component='a', name='T')
        day.note(begun, hold, e.StopReasonChanged(stop_reason='own_fault'))
        day.note(begun + n, e.HoldReleased(hold=str(n)), e.StopReasonChanged(stop_reason=''))
    booked = times(day, '14:00')
    assert [int(entry.hold) for entry in booked.holds] == list(range(21, number + 1))
    assert booked.holds_left_out == 20
    assert booked.left_out_us == {Loss.OWN_FAULT: sum(range(1, 21)) * US}
    assert booked.lost_us[Loss.OWN_FAULT] == sum(range(1, number + 1)) * US
    (repairs,) = booked.repairs
    assert (repairs.failures, repairs.down_us) == (number, booked.lost_us[Loss.OWN_FAULT])


def test_interim_times_are_right_and_change_nothing() -> None:
    day = at_work()
    day.note('06:10', HOLD, e.StopReasonChanged(stop_reason='own_fault'))
    day.note('06:20', e.OrchestratorStarted(cell='c', digest='other'))  # it was killed at 06:10
    day.note('06:30', e.HoldReleased(hold='1'), e.StopReasonChanged(stop_reason=''))
    day.note('06:40', e.ItemRemoved(job='J', item='J/1', how='packed'))
    day.note('06:50', e.ItemRemoved(job='J', item='J/2', how='rejected'), e.HoldReleased(hold='1'))
    planned = Planned.of([(us_of(at('06:00')), us_of(at('07:00')))])
    fold, known = AccountFold(planned, is_whole=True), Day()
    meanwhile = []
    for event in day.events:
        fold.follow(event)
        known.events.append(event)
        end = us_of(event.time) + 9 * 60 * US
        meanwhile.append(fold.until(end))
        expected = AccountFold(planned.before(end), is_whole=True)
        for entry in known.events:
            expected.follow(entry)
        assert meanwhile[-1] == expected.until(end)
    assert fold.until(planned.pieces[0][1]) == times(day, '07:00')
    held, again = meanwhile[6:8]
    assert minutes(held) == {'production': 10, 'own_fault': 9}
    assert minutes(again) == {'production': 10, 'no_node': 10, 'own_fault': 9}
    assert [entry.made[0].produced for entry in meanwhile if entry.made] == [1, 2, 2]


def test_a_stop_across_a_break_is_one_stop() -> None:
    day = at_work()
    day.note('06:10', e.StopReasonChanged(stop_reason='operator', reason='x'))
    day.note('06:22', e.JobHeld(job='Z'))
    day.note('06:27', e.JobHeld(job='Z'))
    day.note('06:40', e.StopReasonChanged(stop_reason=''))
    pieces = [('06:00', '06:20'), ('06:30', '07:00')]
    planned = Planned.of((us_of(at(begin)), us_of(at(end))) for begin, end in pieces)
    fold = AccountFold(planned, is_whole=True)
    for event in day.events:
        fold.follow(event)
    (stop,) = fold.until(us_of(at('07:00'))).stops
    assert (stop.times, stop.us / US / 60) == (1, 20)


@pytest.mark.parametrize('part', [-0.4, 0.4])
def test_event_at_period_end_counts_despite_rounding(part: float) -> None:
    day, end = at_work(), at('06:30') + part * 1e-6
    day.note(end, e.ItemRemoved(job='J', item='J/1', how='packed'), e.JobCompleted(job='J'))
    reading = Reading(day.records())
    for period in (of_job(reading, 'J', 'x'), whole(reading, 'x')):
        (made,) = account(reading, period, None).figures.times.made
        assert (made.good, made.outside) == (1, 0), period


def test_inexact_pace_is_reported_with_its_script() -> None:
    line, day = Line(), Day()
    of_two_sections = f'{THREE}zones: {{table: [work, pack]}}\n'
    for record in line.run(of_two_sections, 2).records:
        day.note(record['time'], from_record(record))
    reading = Reading(day.records())
    notes = account(reading, whole(reading, 'day'), line.cell).notes()
    (pace_note,) = (note for note in notes if 'no exact one' in note)
    assert pace_note.startswith('the pace of test is no exact one: ')
    assert pace_note.endswith('or longer (waits for zone table not counted)')
