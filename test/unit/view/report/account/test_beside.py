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
    periods = [(f'{turn.shift} {turn.day:%d}', turn.period) for turn in turns]
    return beside(Reading(the_day().records()), periods, LINE.cell)


def rows(report: Beside) -> dict[str, Row]:
    return {row.name: row for row in report.groups(None)[0].rows}


def test_every_column_matches_the_naive_account() -> None:
    report, records = made(), [to_record(entry) for entry in the_day().events]
    shown = rows(report)
    for at, column in enumerate(report.columns):
        known = [entry for entry in records if entry['time'] * 1_000_000 <= column.period.end_us]
        naive = naive_account(known, column.period.planned.pieces, lambda _: PACE_US)
        values = {name: row.values[at] for name, row in shown.items()}
        assert values['oee'] == naive.oee
        assert values['good'] == naive.good
        assert values['produced'] == naive.produced
        for loss in ('no_order', 'own_fault', 'operator', 'starved', 'blocked', 'no_node'):
            assert values[loss] == naive.times[loss]


def test_total_is_sum_of_columns() -> None:
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
        sums = [sum(value or 0 for value in column) for column in zip(
            *(group.rows[at].values for group in groups), strict=True
        )]  # fmt: skip
        assert sums == [value or 0 for value in line[row.name].values]
    assert {'name': 'at_pace', 'together': 15540.0}.items() <= beside_plain(report, by)['groups'][
        0
    ]['rows'][-1].items()


def test_components_have_their_stops_failures_and_failed_attempts() -> None:
    groups = {element.name: element.rows for element in made().groups(By.COMPONENT)}
    a2_rows = {row.name: row for row in groups['a2']}
    assert list(groups) == ['a2', 'a1', 'a3', 'lamp']  # as they cost, then those that worked
    assert a2_rows['operated'].together == 22_198 * 1_000_000
    assert a2_rows['lost'].together == 1200 * 1_000_000
    assert [float(element or 0) for element in a2_rows['lost'].values] == [0, 1.2e9, 0, 0, 0, 0]
    # the hold is raised at the end of the first hour, which has it, and stands in the next one
    assert [int(element or 0) for element in a2_rows['failures'].values] == [1, 1, 0, 0, 0, 0]
    assert a2_rows['failures'].together == 1
    assert a2_rows['mttr'].values[1] == 1200 * 1_000_000
    assert a2_rows['mtbf'].values[3] is None
    assert {row.name: row for row in groups['a1']}['lost'].together == 601 * 1_000_000


def test_trend_is_median_change_despite_outlier() -> None:
    def trend(*values: int | None) -> Fraction | None:
        known = tuple(None if value is None else Fraction(value) for value in values)
        return Row('x', 'x', Unit.COUNT, known, None).trend

    assert trend(1, 3, 5, 7) == 2
    assert trend(1, 3, None, 7, 9) == 2
    assert trend(10, 11, 12, 0, 14, 15, 16) == 1
    assert trend(1, None, 7) is None


def test_extremes_are_best_and_worst_oee() -> None:
    report = made()
    values = rows(report)['oee'].values
    best, worst = report.extremes() or pytest.fail('there are none')
    known = [value for value in values if value is not None]
    assert values[report.columns.index(best)] == max(known)
    assert values[report.columns.index(worst)] == min(known) == 0


def test_targets_are_those_of_the_file() -> None:
    report = made()
    shown = rows(report)
    assert (shown['oee'].target, shown['good'].target) == (Fraction(3, 5), None)
    assert shown['oee'].reached == sum((oee or 0) >= Fraction(3, 5) for oee in shown['oee'].values)
    sentence = f'OEE reached its target of 60.0 % in {shown["oee"].reached} of 6'
    assert sentence in list(beside_text(report, None))


def test_largest_losses_name_their_holds_and_reasons() -> None:
    largest = made().largest()
    assert next(loss.bar.title for loss in largest) == 'slow cycles'
    own = next(loss for loss in largest if loss.bar.title == 'own fault')
    assert [(held.who, held.reason) for held in own.holds] == [
        ('ann', 'cleared the jam'),
        ('ann', 'looked at it'),
    ]
    assert not own.is_open


def test_columns_before_journal_are_empty_or_refused() -> None:
    report = made(days=(16, 17, 18))
    assert [column.account is None for column in report.columns] == [True] * 12 + [False] * 6
    assert rows(report)['oee'].together == rows(made())['oee'].together
    plain = json.loads(json.dumps(beside_plain(report, None)))
    assert [column['is_known'] for column in plain['columns']] == [False] * 12 + [True] * 6
    with pytest.raises(NothingToReport, match='it has events from'):
        made(days=(16, 17))
