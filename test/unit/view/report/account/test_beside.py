"""Accounts side by side: each column is true by the journal, and what is said of them together."""

from __future__ import annotations

import json
from datetime import date
from fractions import Fraction

import pytest
from fakes.hand_made_shift import LINE, the_day
from fakes.naive_account import naive_account

from bt_orchestrator.model.codec import to_record
from bt_orchestrator.script.shifts.shifts_file import parse_shifts
from bt_orchestrator.view.report.account.account import NothingToReport
from bt_orchestrator.view.report.account.calendar import turns_on, zone_of
from bt_orchestrator.view.report.account.named_figures import By, Unit
from bt_orchestrator.view.report.beside import Beside, Row, beside
from bt_orchestrator.view.report.beside_words import beside_plain, beside_text
from bt_orchestrator.view.report.reading import Reading

HOURS = """
shifts:
  h06: {from: 06:00, to: 07:00}
  h07: {from: 07:00, to: 08:00}
  h08: {from: 08:00, to: 10:00, breaks: [{from: 09:00, to: 09:30}]}
  h10: {from: 10:00, to: 11:00}
  h11: {from: 11:00, to: 13:00}
  h13: {from: 13:00, to: 14:00}
zone: UTC
target: {oee: 0.6, quality: 0.97}
"""
PACE_US = Fraction(30_000_000)


def made(text: str = HOURS, days: tuple[int, ...] = (18,)) -> Beside:
    shifts = parse_shifts(text, 'shifts.yaml')
    turns = turns_on(shifts, [date(2026, 5, day) for day in days], zone_of(shifts))
    periods = [(f'{one.shift} {one.day:%d}', one.period) for one in turns]
    return beside(Reading(the_day().records()), periods, LINE.cell)


def rows(report: Beside) -> dict[str, Row]:
    return {row.name: row for row in report.groups(None)[0].rows}


def test_a_second_opinion_comes_to_the_same_figures_in_every_column() -> None:
    report, records = made(), [to_record(one) for one in the_day().events]
    shown = rows(report)
    for at, column in enumerate(report.columns):
        known = [one for one in records if one['time'] * 1_000_000 <= column.period.end_us]
        naive = naive_account(known, column.period.planned.pieces, lambda _: PACE_US)
        values = {name: row.values[at] for name, row in shown.items()}
        assert values['oee'] == naive.oee
        assert values['good'] == naive.good
        assert values['produced'] == naive.produced
        for loss in ('no_order', 'own_fault', 'operator', 'starved', 'blocked', 'no_node'):
            assert values[loss] == naive.times[loss]


def test_what_is_told_of_all_together_is_the_sum_of_the_columns() -> None:
    shown = rows(made())
    for name in ('produced', 'good', 'planned', 'own_fault', 'operator', 'setup', 'rejects'):
        assert shown[name].together == sum(value or 0 for value in shown[name].values)
    assert shown['own_fault'].together == 1320 * 1_000_000
    assert shown['oee'].together == Fraction(500 * 30, 26_400)


@pytest.mark.parametrize('by', [By.PRODUCT, By.JOB])
def test_products_and_jobs_add_up_to_the_line(by: By) -> None:
    report = made()
    groups, line = report.groups(by), rows(report)
    for at, row in enumerate(groups[0].rows[:2]):
        told = [sum(value or 0 for value in column) for column in zip(
            *(group.rows[at].values for group in groups), strict=True
        )]  # fmt: skip
        assert told == [value or 0 for value in line[row.name].values]
    assert {'name': 'at_pace', 'together': 15540.0}.items() <= beside_plain(report, by)['groups'][
        0
    ]['rows'][-1].items()


def test_components_have_their_stops_failures_and_failed_attempts() -> None:
    groups = {one.name: one.rows for one in made().groups(By.COMPONENT)}
    told = {row.name: row for row in groups['a2']}
    assert list(groups) == ['a2', 'a1', 'a3', 'lamp']  # as they cost, then those that worked
    assert told['operated'].together == 22_198 * 1_000_000
    assert told['lost'].together == 1200 * 1_000_000
    assert [float(one or 0) for one in told['lost'].values] == [0, 1.2e9, 0, 0, 0, 0]
    # the hold is raised at the end of the first hour, which has it, and stands in the next one
    assert [int(one or 0) for one in told['failures'].values] == [1, 1, 0, 0, 0, 0]
    assert told['failures'].together == 1
    assert told['mttr'].values[1] == 1200 * 1_000_000
    assert told['mtbf'].values[3] is None
    assert {row.name: row for row in groups['a1']}['lost'].together == 601 * 1_000_000


def test_the_trend_is_the_median_change_and_one_bad_day_does_not_turn_it() -> None:
    def trend(*values: int | None) -> Fraction | None:
        known = tuple(None if one is None else Fraction(one) for one in values)
        return Row('x', 'x', Unit.COUNT, known, None).trend

    assert trend(1, 3, 5, 7) == 2
    assert trend(1, 3, None, 7, 9) == 2
    assert trend(10, 11, 12, 0, 14, 15, 16) == 1
    assert trend(1, None, 7) is None


def test_the_best_and_the_worst_are_those_of_the_oee() -> None:
    report = made()
    values = rows(report)['oee'].values
    best, worst = report.extremes() or pytest.fail('there are none')
    known = [one for one in values if one is not None]
    assert values[report.columns.index(best)] == max(known)
    assert values[report.columns.index(worst)] == min(known) == 0


def test_targets_are_those_of_the_file() -> None:
    report = made()
    shown = rows(report)
    assert (shown['oee'].target, shown['good'].target) == (Fraction(3, 5), None)
    assert shown['oee'].reached == sum((one or 0) >= Fraction(3, 5) for one in shown['oee'].values)
    said = f'OEE reached its target of 60.0 % in {shown["oee"].reached} of 6'
    assert said in list(beside_text(report, None))


def test_the_largest_losses_name_their_holds_and_what_was_done() -> None:
    largest = made().largest()
    assert next(one.bar.title for one in largest) == 'slow cycles'
    own = next(one for one in largest if one.bar.title == 'own fault')
    assert [(held.who, held.reason) for held in own.holds] == [
        ('ann', 'cleared the jam'),
        ('ann', 'looked at it'),
    ]
    assert not own.is_open


def test_a_column_before_the_journal_is_empty_and_none_at_all_is_refused() -> None:
    report = made(days=(16, 17, 18))
    assert [one.account is None for one in report.columns] == [True] * 12 + [False] * 6
    assert rows(report)['oee'].together == rows(made())['oee'].together
    plain = json.loads(json.dumps(beside_plain(report, None)))
    assert [one['is_known'] for one in plain['columns']] == [False] * 12 + [True] * 6
    with pytest.raises(NothingToReport, match='it has events from'):
        made(days=(16, 17))
