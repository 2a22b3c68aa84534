"""The account of the shift that runs: at every moment what a report of then would say."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime, timezone
from functools import partial

import pytest
from fakes.day import Day, at
from fakes.hand_made_shift import LINE, SHIFTS, the_day

from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.keeping.records import Damage, Extent, RecordPage, Wanted
from bt_orchestrator.script.shifts.shifts_file import parse_shifts
from bt_orchestrator.store.memory import MemoryRecords, MemoryStore
from bt_orchestrator.view.report.account.account import account
from bt_orchestrator.view.report.account.calendar import Now, shift_at
from bt_orchestrator.view.report.account.live import Live, LiveAccount
from bt_orchestrator.view.report.account.losses import Loss
from bt_orchestrator.view.report.account.period import Period
from bt_orchestrator.view.report.account.plain import account_plain
from bt_orchestrator.view.report.account.planned import US, us_of
from bt_orchestrator.view.report.reading import Reading

EARLY = parse_shifts(SHIFTS, 'shifts.yaml')
TWO = parse_shifts(
    'shifts:\n'
    '  early: {from: 06:00, to: 14:00}\n'
    '  late: {from: 14:00, to: 20:00}\n'
    '  night: {from: 22:00, to: 04:00, days: [mon]}\n'
    'zone: UTC\n',
    'shifts.yaml',
)
DAY = the_day()


def journal(events: Sequence[e.Event], until: float, history: str = 'day') -> MemoryRecords:
    """Return the journal as it was at a moment."""
    store = MemoryStore(history)
    store.append([event for event in events if event.time <= until])
    return MemoryRecords(store)


def live(shifts: object = EARLY) -> LiveAccount:
    assert shifts in (EARLY, TWO)
    return LiveAccount(partial(shift_at, EARLY if shifts is EARLY else TWO), LINE.cell)


def looked(account: LiveAccount, clock: str, history: str = 'day') -> Live:
    shown = account.look(journal(DAY.events, at(clock), history), at(clock))
    assert shown is not None
    return shown


def report_of(live: Live, clock: str) -> object:
    """Return what the report of the same period says that is made at that moment."""
    return account_plain(
        account(Reading(journal(DAY.events, at(clock))), live.account.period, LINE.cell)
    )


def test_live_report_equals_report_at_any_moment() -> None:
    grows = live()
    for clock in ('06:18', '07:10', '09:15', '12:05', '14:10'):
        shown = looked(grows, clock)
        assert account_plain(shown.account) == report_of(shown, clock), clock
        assert shown.account.period.end_us == us_of(at(min(clock, '14:00')))
    assert looked(live(), '14:10') == shown, 'as if one had just begun to look'
    assert shown.account.figures.oee is not None
    assert float(shown.account.figures.oee) == 500 * 30 / 26400


def test_last_shift_is_shown_until_next_begins() -> None:
    grows = live(TWO)
    seen = []
    for clock in ('13:59', '14:00', '14:10', '20:00', '21:59', '22:00'):
        shown = looked(grows, clock)
        assert shown.now.turn is not None
        next_one = shown.now.next
        seen.append((shown.now.turn.shift, next_one.shift if next_one else ''))
        assert looked(live(TWO), clock) == shown
    assert seen == [
        ('early', ''), ('late', ''), ('late', ''), ('late', 'night'), ('late', 'night'),
        ('night', ''),
    ]  # fmt: skip
    assert shown.now.period.name == 'shift night of 2026-05-18'
    late = looked(grows, '21:00')
    assert late.account.figures.produced == 1
    assert late.account.period.end_us == us_of(at('20:00'))


def test_last_shift_is_shown_on_day_without_shift() -> None:
    sunday = datetime(2026, 5, 24, 12, tzinfo=timezone.utc).timestamp()
    only = parse_shifts('shifts: {a: {from: 06:00, to: 14:00, days: fri}}\nzone: UTC', 'x')
    now = shift_at(only, sunday)
    assert now.turn is not None
    assert now.next is not None
    assert (str(now.turn.day), str(now.next.day)) == ('2026-05-22', '2026-05-29')


def test_another_history_begins_anew() -> None:
    grows = live()
    before = looked(grows, '10:00').account
    assert looked(grows, '10:00', 'other').account.source.extent.history == 'other'
    assert looked(grows, '10:00').account == before


class Removed(MemoryRecords):
    """A journal that retention has removed events from."""

    def __init__(self, events: Sequence[e.Event], first_seq: int) -> None:
        store = MemoryStore('day')
        store.append(events)
        super().__init__(store)
        self._first_seq = first_seq

    def extent(self) -> Extent:
        return super().extent()._replace(first_seq=self._first_seq)

    def page(self, wanted: Wanted, most: int = 1000) -> RecordPage:
        inner = super().page(wanted.past(self._first_seq - 1), most)
        damage = [Damage('event 3 is damaged')]
        return RecordPage('day', self._first_seq, inner.records, damage, inner.rest, inner.is_last)


def test_account_keeps_events_read_before_removal() -> None:
    grows, events = live(), [event for event in DAY.events if event.time <= at('10:00')]
    whole = looked(grows, '10:00').account.figures
    kept = grows.look(Removed(events, len(events)), at('10:00'))
    assert kept is not None
    assert kept.account.figures == whole
    assert kept.account.source.extent.first_seq == len(events)
    later = [event for event in DAY.events if event.time <= at('12:00')]
    lost = grows.look(Removed(later, len(events) + 9), at('12:00'))
    assert lost is not None
    assert lost.account.figures.times.lost_us[Loss.NOT_RECORDED] >= 4 * 3600 * US


def test_damage_seen_repeatedly_is_counted_once() -> None:
    messages: list[str] = []
    grows = LiveAccount(partial(shift_at, EARLY), LINE.cell, messages.append)
    for clock in ('10:00', '11:00', '12:00'):
        events = [event for event in DAY.events if event.time <= at(clock)]
        shown = grows.look(Removed(events, 1), at(clock))
        assert shown is not None
        assert shown.account.source.unreadable == 1
    assert messages == ['event 3 is damaged']


def test_a_journal_without_events_has_no_account() -> None:
    assert live().look(MemoryRecords(MemoryStore()), at('10:00')) is None


def test_shift_without_events_continues_previous_state() -> None:
    day = Day()
    day.note('13:00', *DAY.events[:10])
    day.note('13:00', e.StopReasonChanged(stop_reason='operator', reason='x'))
    shown = live(TWO).look(journal(day.events, at('15:00')), at('15:00'))
    assert shown is not None
    assert shown.account.figures.times.lost_us == {Loss.OPERATOR: 3600 * US}
    assert shown.account.notes()[0].startswith('made from the state that event 11 left, ')


def test_reader_with_slow_clock_follows_event_times() -> None:
    shown = live().look(journal(DAY.events, at('09:00')), at('08:00'))
    assert shown is not None
    assert shown.account.period.end_us == us_of(at('08:10'))  # of the last event before 09:00
    assert looked(live(), '08:10').account.figures == shown.account.figures


@pytest.mark.parametrize(
    ('clock', 'loss', 'since'),
    [('07:10', 'own_fault', '07:00'), ('08:05', 'operator', '08:00'), ('07:40', None, None)],
)
def test_what_the_line_waits_for_now(clock: str, loss: str | None, since: str | None) -> None:
    stopped = looked(live(), clock).stopped
    if loss is None or since is None:
        assert stopped is None
    else:
        assert stopped is not None
        assert (stopped.cause.loss.value, stopped.since_us) == (loss, us_of(at(since)))
    assert looked(live(), '23:00').stopped is None


def test_time_before_first_event_is_not_lost() -> None:
    day = Day()
    day.note('07:20', e.OrchestratorStarted(cell='test_line', digest=digest(LINE.cell)))
    shown = live().look(journal(day.events, at('07:30')), at('07:30'))
    assert shown is not None
    assert shown.stopped is not None
    lost = shown.account.figures.times.lost_us[Loss.NO_ORDER]
    assert (shown.stopped.since_us, lost) == (us_of(at('07:20')), 600 * US)


def test_a_period_without_shifts_grows_with_the_time() -> None:
    begin = us_of(at('07:00'))
    whole = Period.all_planned('since 07:00', begin, begin + 10**15)
    grows = LiveAccount(lambda _: Now(whole), LINE.cell)
    for clock in ('07:10', '09:00', '14:30'):
        shown = looked(grows, clock)
        assert account_plain(shown.account) == report_of(shown, clock)
        assert shown.account.period.end_us == us_of(at(clock))


@pytest.mark.parametrize(
    'later',
    [
        pytest.param(e.ClockStepped(seconds=5400.0), id='by the clock it is over sooner'),
        pytest.param(
            e.OperatorDecided(answer='classify', who='Ann', reason='', code='JAM', hold='1'),
            id='somebody says the reason of a stop',
        ),
    ],
)
def test_late_event_that_changes_account_is_seen(later: e.Event) -> None:
    before = [event for event in DAY.events if event.time <= at('13:00')]
    records = [journal(before, at('13:00'))]
    records += [journal([*before, later.stamped(len(before) + 1, at('14:30'))], at('14:30'))]
    grows = live()
    for known, clock in zip(records, ('13:00', '14:31'), strict=True):
        shown = grows.look(known, at(clock))
        assert shown == live().look(known, at(clock)), clock
    assert shown is not None
    assert shown.account != looked(live(), '14:31').account
