"""Collecting findings, and guessing what was meant."""

from __future__ import annotations

import pytest

from bt_orchestrator.base.errors import Refused
from bt_orchestrator.script.report import (
    MOST_FINDINGS,
    Place,
    Report,
    did_you_mean,
    listing,
    nearest,
)


def test_findings_are_in_file_order_without_duplicates() -> None:
    report = Report('a.yaml')
    for line, column in ((2, 1), (1, 9), (1, 2), (2, 1)):
        report.add(Place(line, column), 'wrong', 'mend it')
    assert [(flaw.line, flaw.column) for flaw in report.findings] == [(1, 2), (1, 9), (2, 1)]
    with pytest.raises(Refused, match=r'a\.yaml:1:2: wrong; mend it'):
        report.refuse()


def test_nothing_wrong_is_not_refused() -> None:
    report = Report('a.yaml')
    report.refuse()
    assert report.findings == ()


@pytest.mark.parametrize(
    ('name', 'expected'),
    [('retrys', 'retries'), ('RETRIES', 'retries'), ('timeot', 'timeout'), ('colour', None)],
)
def test_the_nearest_name(name: str, expected: str | None) -> None:
    assert nearest(name, ['retries', 'timeout', 'retry_delay']) == expected


def test_the_nearest_name_keeps_its_own_spelling() -> None:
    assert did_you_mean('task_a', ['TASK_A', 'TASK_B'], '') == 'did you mean `TASK_A`?'
    assert did_you_mean('x', ['TASK_A'], 'look it up') == 'look it up'
    assert nearest('x', []) is None


@pytest.mark.parametrize('wrong', ['tsak_1500', 'x_task_1500', 'TASK_1500', 'task1500'])
def test_among_thousands_the_nearest_is_still_found(wrong: str) -> None:
    known = [f'task_{number}' for number in range(1000, 3000)]
    near = nearest(wrong, known)
    assert near is not None
    assert near.startswith('task_15')


def test_a_long_list_is_cut() -> None:
    assert listing(['a', 'b']) == '`a`, `b`'
    assert listing('abcd', longest=2) == '`a`, `b`, ...'


def test_reading_ends_where_there_are_too_many_mistakes() -> None:
    report = Report('a.yaml')
    for line in range(1, MOST_FINDINGS):
        report.add(Place(line, 1), 'wrong', 'mend it')
    with pytest.raises(Refused) as caught:
        report.add(Place(MOST_FINDINGS, 1), 'wrong', 'mend it')
    assert len(caught.value.findings) == MOST_FINDINGS + 1
    assert str(caught.value.findings[-1]) == (
        f'a.yaml:{MOST_FINDINGS}:1: reading ended here, with {MOST_FINDINGS} mistakes; mend these '
        'first'
    )
