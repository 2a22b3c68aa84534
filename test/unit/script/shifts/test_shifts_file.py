"""The file of shifts: what it says, and every mistake with its place."""

from __future__ import annotations

import pytest

from bt_orchestrator.base.errors import Refused
from bt_orchestrator.model.plant.shifts import Hours, Shift, Shifts
from bt_orchestrator.script.shifts.shifts_file import parse_shifts


def mistakes(text: str) -> list[str]:
    with pytest.raises(Refused) as caught:
        parse_shifts(text, 's.yaml')
    return [str(finding) for finding in caught.value.findings]


def test_shifts_with_breaks_days_and_zone() -> None:
    text = """
shifts:
  early: {from: 06:00, to: 14:00, breaks: [{from: 09:00, to: 09:15}], days: [fri, mon, mon]}
  night: {from: "22:00", to: 06:00, breaks: [{from: 02:00, to: 02:30}]}
  all: {from: 00:00, to: 24:00}
zone: Europe/Berlin
"""
    early = Shift('early', Hours(360, 840), (Hours(540, 555),), (0, 4))
    night = Shift('night', Hours(1320, 360), (Hours(120, 150),))
    whole = Shift('all', Hours(0, 0))
    both = Shifts({shift.name: shift for shift in (early, night, whole)}, 'Europe/Berlin')
    assert parse_shifts(text, 's.yaml') == both
    assert [shift.hours.minutes for shift in both.shifts.values()] == [480, 480, 1440]


EARLY = 'shifts: {a: {from: 06:00, to: 14:00'
MISTAKES = {
    'shifts: {a: {from: 6:00, to: 14:00}}': (
        's.yaml:1:20: `from` must be a time of the clock, not `6:00`; write for instance 06:00; '
        'hours have two digits'
    ),
    'shifts: {a: {from: 06:00}}': (
        's.yaml:1:13: a shift needs the key `to`; write for instance `to: 14:00`'
    ),
    f'{EARLY}, days: [tus]}}}}': 's.yaml:1:45: no day is named `tus`; did you mean `tue`?',
    f'{EARLY}, breaks: [{{from: 13:50, to: 14:05}}]}}}}': (
        's.yaml:1:54: the break is not within shift a; change its times'
    ),
    f'{EARLY}}}}}\nzone: Berlin/Europe': (
        's.yaml:2:7: this computer knows no time zone `Berlin/Europe`; write for instance '
        '`zone: Europe/Berlin`; the package tzdata has them all'
    ),
    f'{EARLY}}}}}\ntarget: {{oee: 75}}': (
        's.yaml:2:15: `oee` must be at most 1, not the number 75; write for instance `oee: 0.75`'
    ),
    f'{EARLY}}}}}\ntarget: {{oe: 0.75}}': (
        's.yaml:2:10: a target has no key `oe`; did you mean `oee`?'
    ),
    f'{EARLY}}}}}\nmicro_stop: 5': (
        's.yaml:2:13: `micro_stop` must be at least 10, not the number 5; write for instance '
        '`micro_stop: 120`'
    ),
    'shifts: {}': (
        's.yaml:1:9: no shift is named; write for instance '
        '`shifts: {early: {from: 06:00, to: 14:00}}`'
    ),
}


@pytest.mark.parametrize(('text', 'what'), MISTAKES.items())
def test_a_mistake_is_told_with_its_place(text: str, what: str) -> None:
    assert mistakes(text) == [what]


def test_another_kind_of_file_is_named() -> None:
    (finding,) = mistakes('cell: x\nconveyor: {}\ncomponents: {}\n')
    assert 'this is a cell file, and a file of shifts is expected' in finding
