"""A period in which nothing happened: its time is booked, and its factors are 0 or not known."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from contextlib import closing
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest
from fakes.day import Day, at
from fakes.hand_made_shift import LINE, SCRIPT, held_raised, stopped, to
from fakes.hand_made_shift import started as task_started
from fakes.kept_books import book_all

from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import digest
from bt_orchestrator.ports import Snapshot
from bt_orchestrator.store.sqlite.records import SqliteRecords
from bt_orchestrator.store.sqlite.store import SqliteStore
from bt_orchestrator.view.drawing.account.page import account_page
from bt_orchestrator.view.report.account.account import Account, NothingToReport, account
from bt_orchestrator.view.report.account.losses import Loss
from bt_orchestrator.view.report.account.period import Period
from bt_orchestrator.view.report.account.plain import account_plain, write_csv
from bt_orchestrator.view.report.account.planned import Planned, us_of
from bt_orchestrator.view.report.account.text import account_text
from bt_orchestrator.view.report.reading import Reading

HOUR_US = 3_600_000_000
QUIET = Period.all_planned('shift night', us_of(at('14:00')), us_of(at('15:00')))

NODE = e.OrchestratorStarted(cell='test_line', digest=digest(LINE.cell))
LOADED = e.ScriptLoaded(script='test', digest=digest(SCRIPT), definition=SCRIPT)


def queued(*, held: bool = False) -> e.Event:
    return e.JobQueued(job='J', script='test', digest=digest(SCRIPT), quantity=9, held=held)


WORKS = (to('Execute'), e.JobStarted(job='J'), task_started('work', 'a2'))
ENDED = e.OrchestratorStopping()

CASES: dict[str, tuple[Sequence[e.Event], Sequence[e.Event], Loss]] = {
    'no order': ((), (), Loss.NO_ORDER),
    'queued, not started': ((LOADED, queued()), (), Loss.OPERATOR),
    'every order is held': ((LOADED, queued(held=True)), (), Loss.ORDERS_WAIT),
    'held': ((LOADED, queued(), *WORKS, held_raised(), stopped('own_fault')), (), Loss.OWN_FAULT),
    'stopped': ((LOADED, queued(), *WORKS, stopped('operator', 'ann')), (), Loss.OPERATOR),
    'the node has ended': ((LOADED, queued(), *WORKS, ENDED), (NODE,), Loss.NO_NODE),
    'the node was killed': ((LOADED, queued(), *WORKS), (NODE,), Loss.NO_NODE),
}


def quiet(before: Sequence[e.Event], after: Sequence[e.Event]) -> Account:
    day = Day()
    day.note('13:00', NODE, *before)
    if after:
        day.note('16:00', *after)
    return account(Reading(day.records()), QUIET, LINE.cell)


@pytest.mark.parametrize('goes_on', [False, True])
@pytest.mark.parametrize('case', CASES)
def test_a_quiet_period_is_reported_with_its_cause(case: str, goes_on: bool) -> None:
    before, after, loss = CASES[case]
    if goes_on:
        after = after or (e.ComponentStateChanged(component='a1', ready=True, value='READY'),)
    report = quiet(before, after)
    shown = report.figures
    assert shown.times.lost_us == {loss: HOUR_US}
    is_busy = loss not in (Loss.NO_ORDER, Loss.ORDERS_WAIT)
    assert shown.availability == shown.oee == (Fraction(0) if is_busy else None)
    assert (shown.performance, shown.quality) == (None, None)
    lack = 'production' if is_busy else 'busy'
    sentence = 'nothing was produced, in no production time' if is_busy else 'busy time is 0'
    text = '\n'.join(account_text(report))
    assert sentence in text
    assert f'OEE  {"0.0 %" if is_busy else "-"} =' in text
    assert sentence in account_page(report)
    plain = account_plain(report)
    assert plain['lack'] == lack
    assert plain['oee']['availability'] == (0.0 if is_busy else None)
    file = io.StringIO()
    write_csv(report, file)
    assert any(row[:2] == ['note', lack] for row in csv.reader(io.StringIO(file.getvalue())))
    ends = 'the journal has no event since 2026-05-18'
    assert any(note.startswith(ends) for note in report.notes()) is not bool(after)


def test_a_report_says_what_the_orders_waited_for() -> None:
    before, _, _ = CASES['every order is held']
    sentence = 'orders waited for 1:00:00: held in the queue'
    assert sentence in quiet(before, ()).notes()
    before, _, _ = CASES['no order']
    assert not any('orders waited' in note for note in quiet(before, ()).notes())


def test_hold_of_whole_period_is_named() -> None:
    before, _, _ = CASES['held']
    (held,) = quiet(before, ()).figures.times.holds
    assert (held.hold, held.lost_us) == ('1', HOUR_US)


@pytest.mark.parametrize('in_books', [False, True])
def test_a_period_without_planned_time_has_no_factors(tmp_path: Path, in_books: bool) -> None:
    day = Day()
    day.note('13:00', NODE, LOADED, queued(), *WORKS)
    day.note('14:20', e.ItemRemoved(job='J', item='J/1', section=3, how='packed'))
    day.note('16:00', e.JobCompleted(job='J'))
    path = tmp_path / 'journal'
    with closing(SqliteStore(path)) as store:
        store.append(day.events)
        if in_books:
            book_all(store, path)
            store.begin_with(Snapshot(len(day.events), '', '{}'))
            while store.remove_batch(len(day.events)):
                pass
    with closing(SqliteRecords(path)) as records:
        report = account(Reading(records), replace(QUIET, planned=Planned(())), LINE.cell)
    shown = report.figures
    assert (shown.availability, shown.performance, shown.quality, shown.oee) == (None,) * 4
    assert (shown.times.lost_us, shown.produced) == ({}, 0)
    sentence = 'no factors and no OEE: no time of this period is planned'
    assert sentence in '\n'.join(account_text(report))
    assert sentence in account_page(report)
    plain = account_plain(report)
    assert plain['lack'] == 'planned'
    assert plain['jobs'][0]['outside_planned_time'] == 1


def test_a_period_before_the_journal_is_refused() -> None:
    day = Day()
    day.note('16:00', NODE)
    with pytest.raises(NothingToReport, match='the journal has no event of shift night'):
        account(Reading(day.records()), QUIET, None)


def test_production_without_an_item_lacks_only_quality() -> None:
    report = quiet((LOADED, queued(), *WORKS), (e.ComponentInService(component='a1'),))
    shown = report.figures
    assert (shown.availability, shown.performance) == (Fraction(1), Fraction(0))
    assert shown.quality is None
    assert 'no quality: nothing was produced' in report.notes()
