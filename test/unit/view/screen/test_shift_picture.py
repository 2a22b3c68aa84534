"""The picture of the shift that runs: what stays where there is little room."""

from __future__ import annotations

from functools import partial

import pytest
from fakes.day import at
from fakes.hand_made_shift import LINE, SHIFTS, the_day

from bt_orchestrator.script.shifts.shifts_file import parse_shifts
from bt_orchestrator.view.report.account.calendar import shift_at
from bt_orchestrator.view.report.account.live import Live, LiveAccount
from bt_orchestrator.view.screen.fit import ASCII, UNICODE, Glyphs
from bt_orchestrator.view.screen.shift import ShiftPicture

JOURNAL = the_day().records()


def live(clock: str) -> Live:
    shifts = parse_shifts(SHIFTS, 'shifts.yaml')
    shown = LiveAccount(partial(shift_at, shifts), LINE.cell).look(JOURNAL, at(clock))
    assert shown is not None
    return shown


def drawn(clock: str, width: int = 80, room: int = 24, glyphs: Glyphs = UNICODE) -> list[str]:
    return [line.plain.rstrip() for line in ShiftPicture(live(clock)).lines(width, room, glyphs)]


def test_a_shift_that_is_over() -> None:
    lines = drawn('23:00')
    assert lines[0] == f'{"test_line, shift early of 2026-05-18":60}06:00:00 to 14:00:00'
    assert lines[1] == 'it is over; early begins 2026-05-19 06:00:00'
    assert lines[4].startswith('  = availability 81.4 % ')
    assert 'made 518, 500 of them good' in lines
    first, second = lines[lines.index('lost') + 1 :][:2]
    assert first.startswith('slow cycles ')
    assert second.startswith('own fault            0:22:00    4.9 % █')


@pytest.mark.parametrize('width', [20, 40, 60, 120])
@pytest.mark.parametrize('room', [1, 5, 12, 40])
def test_it_keeps_to_its_room(width: int, room: int) -> None:
    lines = ShiftPicture(live('23:00'), 'the journal cannot be read').lines(width, room, ASCII)
    assert len(lines) <= room
    assert all(line.cell_len <= width for line in lines)
    assert all(line.plain.isascii() for line in lines if '…' not in line.plain)


def test_a_journal_without_an_event() -> None:
    (line,) = ShiftPicture(None).lines(80, 24)
    assert line.plain == 'the journal has no event yet'
