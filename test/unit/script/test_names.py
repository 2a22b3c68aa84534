"""Names that users choose."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from bt_orchestrator.script.names import check_id, check_name, wrong_order_id
from bt_orchestrator.script.report import START, Place, Report

Check = Callable[[str, str, Place, Report], bool]


@pytest.mark.parametrize(
    ('check', 'text', 'is_legal'),
    [
        (check_id, '4.1', True),
        (check_id, 'init.2', True),
        (check_id, 'prüfen-2_b', True),
        (check_id, '.a', False),
        (check_id, 'a.', False),
        (check_id, 'a..b', False),
        (check_id, 'a/b', False),
        (check_id, 'a}', False),
        (check_id, '', False),
        (check_id, 'a' * 64, True),
        (check_id, 'a' * 65, False),
        (check_name, 'shared_table', True),
        (check_name, '3a', True),
        (check_name, 'a.b', False),
        (check_name, 'a b', False),
    ],
)
def test_ids_and_names(check: Check, text: str, is_legal: bool) -> None:
    report = Report('a.yaml')
    assert check(text, 'thing', START, report) is is_legal
    assert len(report.findings) == (not is_legal)


@pytest.mark.parametrize(
    ('text', 'what'),
    [
        ('WO-1001', None),
        ('order 7, urgent', None),
        ('', 'it is empty'),
        ('a/1', 'a slash'),
        (' a', 'begins or ends with a space'),
        ('a\n', 'begins or ends with a space'),
        ('a\tb', 'cannot be printed'),
        ('x' * 65, 'it has 65 characters'),
    ],
)
def test_order_ids(text: str, what: str | None) -> None:
    wrong = wrong_order_id(text)
    assert (wrong is None) is (what is None)
    assert wrong is None or (what or '') in wrong[0]


@pytest.mark.parametrize('text', ['a b', '.a', 'a/b', '///', 'ä/ö'])
def test_the_spelling_that_is_offered_is_legal(text: str) -> None:
    report = Report('a.yaml')
    check_id(text, 'thing', START, report)
    offered = report.findings[0].hint.split('`')[1]
    assert check_id(offered, 'thing', START, Report('b.yaml'))
