"""The page of an account: complete in itself, and what somebody wrote is text in it."""

from __future__ import annotations

import re
from datetime import date
from html.parser import HTMLParser

import pytest
from fakes.day import Day, at
from fakes.hand_made_shift import LINE, SHIFTS, the_day

from bt_orchestrator.model import events as e
from bt_orchestrator.script.shifts.shifts_file import parse_shifts
from bt_orchestrator.view.drawing.account.page import account_page
from bt_orchestrator.view.drawing.account.tables import bar
from bt_orchestrator.view.report.account.account import account
from bt_orchestrator.view.report.account.calendar import shift_on, zone_of
from bt_orchestrator.view.report.reading import Reading

ALONE = ('meta',)
"""Elements without an end."""


class Reader(HTMLParser):
    """Reads a page; every element has to be closed in its turn."""

    def __init__(self) -> None:
        super().__init__()
        self.rows: list[str] = []
        self.names: set[str] = set()
        self._open: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.names |= {tag, *(name for name, _ in attrs)}
        if tag == 'tr':
            self.rows.append('')
        if tag not in ALONE:
            self._open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.names |= {tag, *(name for name, _ in attrs)}

    def handle_endtag(self, tag: str) -> None:
        assert self._open.pop() == tag

    def handle_data(self, data: str) -> None:
        if 'tr' in self._open and data.strip():
            self.rows[-1] += f'{data}|'

    def close(self) -> None:
        super().close()
        assert not self._open


def page_of(day: Day) -> str:
    shifts = parse_shifts(SHIFTS, 'shifts.yaml')
    period = shift_on(shifts.shifts['early'], date(2026, 5, 18), zone_of(shifts), at('23:00'))
    return account_page(account(Reading(day.records()), period, LINE.cell))


@pytest.fixture(scope='module')
def page() -> str:
    return page_of(the_day())


def read(text: str) -> Reader:
    reader = Reader()
    reader.feed(text)
    reader.close()
    return reader


def test_every_figure_is_in_its_row(page: str) -> None:
    rows = read(page).rows
    assert 'planned busy time|7:20:00|97.8 %|' in rows
    assert 'own fault|\N{MINUS SIGN}0:22:00|4.9 %|' in rows
    assert 'own fault, fault|a2, TASK_A aborted|0:20:00|1|24.4 %|' in rows
    assert 'waiting for an answer|0:02:00|0.4 %|' in rows
    assert 'breakdowns|1|0:20:00|' in rows
    assert 'J|test|30.0 s|500|6|10|2|20|' in rows
    assert 'a2|1|0:20:00|6:09:58|0:20:00|' in rows
    assert 'rejected, test|by the script|10|55.6 %|' in rows


def test_it_needs_nothing_else(page: str) -> None:
    names = read(page).names
    assert names.isdisjoint({'script', 'link', 'src', 'href', 'img'})
    assert 'url(' not in page
    assert 'http' not in page


def test_what_somebody_wrote_is_text() -> None:
    day = Day()
    evil = '</style><script>alert(1)</script>&\x00'
    day.note('06:00', e.OrchestratorStarted(cell=evil, digest='d'))
    day.note('06:00', e.JobQueued(job=evil, script=evil, digest='d', quantity=1))
    hold = e.HoldRaised(hold='1', reason=evil, message=evil, component=evil, task=evil)
    day.note('06:01', hold, e.StopReasonChanged(stop_reason='own_fault'))
    failed = e.TaskFailed(job=evil, task=evil, attempt=1, reason=evil)
    day.note('06:02', failed, e.ItemRemoved(job=evil, item='x', how='packed'))
    decided = e.OperatorDecided(answer=evil, who=evil, reason=evil, hold='1')
    day.note('06:03', decided, e.HoldReleased(hold='1'), e.StopReasonChanged(stop_reason=''))
    text = page_of(day)
    assert 'script' not in read(text).names
    assert '<script' not in text
    assert '\x00' not in text


def test_bars_of_a_waterfall_hang_on_each_other(page: str) -> None:
    whole, no_order, busy = (
        tuple(float(number) for number in groups)
        for groups in re.findall(r'<rect x="([\d.]+)" y="0" width="([\d.]+)"', page)[:3]
    )
    assert whole == (0.0, 1000.0)
    assert no_order == (977.78, 22.22)
    assert busy == (0.0, 977.78)


@pytest.mark.parametrize(
    ('begin', 'end', 'drawn'),
    [
        (0.0, 0.0, None),
        (0.5, 0.5001, ('500', '2')),
        (1.0, 0.9999, ('998', '2')),
        (0.8, 1.7, ('800', '200')),
    ],
)
def test_narrow_bar_is_visible_and_wide_bar_ends(
    begin: float, end: float, drawn: tuple[str, str] | None
) -> None:
    match = re.search(r'x="([\d.]+)" y="0" width="([\d.]+)"', bar(begin, end))
    assert (match and match.groups()) == drawn
