"""Values of records, for a person."""

from __future__ import annotations

from typing import Any

import pytest

from bt_orchestrator.view.report.tables import shown


@pytest.mark.parametrize(
    ('plain', 'text'),
    [
        ('aborted', 'aborted'),
        ('two words', '"two words"'),
        ('', '""'),
        ({'$float': 'nan'}, 'NaN'),
        ({'x': [{'$float': '-inf'}]}, '{"x": [-Infinity]}'),
        ('\x1b[2J', '"\\u001b[2J"'),
        ('a\x9bb', '"a\\u009bb"'),
        ('a\x7fb', '"a\\u007fb"'),
        ({'☃': '\ud800'}, '{"\\u2603": "\\ud800"}'),
        ({'☃': 1}, '{"☃": 1}'),
    ],
)
def test_shown_values_are_readable_and_terminal_safe(plain: Any, text: str) -> None:
    assert shown(plain) == text
