"""When shifts are: over midnight, on days of the week, and where the clocks change."""

from __future__ import annotations

from datetime import date, datetime
from io import StringIO
from zoneinfo import ZoneInfo

import pytest
from fakes.day import Day

from bt_orchestrator.model.events import OrchestratorStarted
from bt_orchestrator.script.shifts.shifts_file import parse_shifts
from bt_orchestrator.view.drawing.account.page import account_page
from bt_orchestrator.view.report.account.account import Account, account
from bt_orchestrator.view.report.account.calendar import (
    changed_breaks,
    last_begun,
    planned_within,
    shift_on,
    zone_of,
)
from bt_orchestrator.view.report.account.period import Period
from bt_orchestrator.view.report.account.plain import account_plain, write_csv
from bt_orchestrator.view.report.account.planned import US, Planned
from bt_orchestrator.view.report.reading import Reading

SHIFTS = parse_shifts(
    'shifts:\n'
    '  day: {from: 06:00, to: 22:00, days: [mon, tue, wed, thu, fri]}\n'
    '  night: {from: 22:00, to: 06:00, breaks: [{from: 00:30, to: 01:00}]}\n'
    'zone: Europe/Berlin\n',
    'shifts.yaml',
)
ZONE = zone_of(SHIFTS)
NIGHT = SHIFTS.shifts['night']
FAR = datetime(2030, 1, 1).timestamp()


def us(text: str) -> int:
    return (
        int(datetime.fromisoformat(text).replace(tzinfo=ZoneInfo('Europe/Berlin')).timestamp())
        * US
    )


def test_night_shift_ends_after_break_on_next_day() -> None:
    period = shift_on(NIGHT, date(2026, 5, 18), ZONE, FAR)
    assert (period.begin_us, period.end_us) == (us('2026-05-18T22:00'), us('2026-05-19T06:00'))
    assert period.planned.pieces == (
        (us('2026-05-18T22:00'), us('2026-05-19T00:30')),
        (us('2026-05-19T01:00'), us('2026-05-19T06:00')),
    )


def test_night_shift_length_follows_clock_change() -> None:
    nights = [shift_on(NIGHT, date(2026, 10, day), ZONE, FAR) for day in (23, 24, 25)]
    assert [night.planned.total_us / US / 3600 for night in nights] == [7.5, 8.5, 7.5]
    spring = shift_on(NIGHT, date(2026, 3, 28), ZONE, FAR)
    assert spring.planned.total_us / US / 3600 == 6.5


WITH_MEAL = parse_shifts(
    'shifts: {night: {from: 22:00, to: 06:00, breaks: [{from: 01:45, to: 03:00}]}}\n'
    'zone: Europe/Berlin\n',
    'shifts.yaml',
)


@pytest.mark.parametrize(
    ('day', 'took', 'words'),
    [
        (date(2026, 10, 24), 8100, 'took 2:15:00 instead of 1:15:00: the clocks went back in it'),
        (date(2026, 3, 28), 900, 'took 0:15:00 instead of 1:15:00: the clocks went forward in it'),
    ],
)
def test_break_with_clock_change_is_reported(day: date, took: int, words: str) -> None:
    night = WITH_MEAL.shifts['night']
    period = shift_on(night, day, ZONE, FAR)
    made = night_of(period)
    assert [note for note in made.notes() if note.endswith(words)]
    (plain,) = account_plain(made)['changed_breaks']
    assert (plain['shift'], plain['seconds'], plain['usual_seconds']) == ('night', took, 4500.0)
    (changed_break,) = changed_breaks(WITH_MEAL, period.begin_us, period.end_us)
    assert period.changed_breaks == (changed_break,)
    table = StringIO()
    write_csv(made, table)
    assert f'note,changed_breaks,,{plain["from"]},,{took}.0,' in table.getvalue()
    page = account_page(made)
    assert words in page
    before = shift_on(night, day, ZONE, period.begin_us / US + 3600)
    assert not before.changed_breaks, 'it has not begun'


def test_other_breaks_are_not_told() -> None:
    plain = account_plain(night_of(shift_on(NIGHT, date(2026, 5, 18), ZONE, FAR)))
    assert 'changed_breaks' not in plain
    assert 'clock_set' not in plain


def night_of(period: Period) -> Account:
    day = Day()
    day.note(period.begin_us / US, OrchestratorStarted(cell='test_line', digest=''))
    return account(Reading(day.records()), period, None)


def test_the_last_one_that_has_begun() -> None:
    saturday = us('2026-05-23T12:00') / US
    assert last_begun(SHIFTS.shifts['day'], ZONE, saturday) == date(2026, 5, 22)
    assert last_begun(NIGHT, ZONE, saturday) == date(2026, 5, 22)
    assert last_begun(NIGHT, ZONE, us('2026-05-23T22:00') / US) == date(2026, 5, 22)
    assert last_begun(NIGHT, ZONE, us('2026-05-23T22:01') / US) == date(2026, 5, 23)


def test_running_shift_is_cut_at_now() -> None:
    period = shift_on(NIGHT, date(2026, 5, 18), ZONE, us('2026-05-19T02:00') / US)
    assert period.cut().planned.total_us == 3.5 * 3600 * US


def test_all_shifts_of_a_period() -> None:
    """From Friday noon to Monday noon: nobody works by day at the weekend."""
    planned = planned_within(SHIFTS, us('2026-05-22T12:00'), us('2026-05-25T12:00'))
    assert planned.total_us / US / 3600 == 10 + 3 * 7.5 + 6
    assert planned.pieces[0] == (us('2026-05-22T12:00'), us('2026-05-23T00:30'))


def test_planned_pieces_are_merged_and_include_their_ends() -> None:
    planned = Planned.of([(0, 10), (5, 20), (30, 40)], [(8, 12), (35, 36)])
    assert planned.pieces == ((0, 8), (12, 20), (30, 35), (36, 40))
    assert planned.between(0, 100) == planned.total_us == 25
    assert planned.between(7, 13) == 2
    assert planned.between(20, 30) == 0
    inside = [moment for moment in range(45) if planned.includes(moment)]
    assert inside == [*range(1, 9), *range(13, 21), *range(31, 36), *range(37, 41)]
