"""How long spans last together."""

from __future__ import annotations

import pytest

from bt_orchestrator.view.report.intervals import Span, covered_s


@pytest.mark.parametrize(
    ('spans', 'seconds'),
    [
        ([], 0.0),
        ([Span(1.0, 3.0)], 2.0),
        ([Span(5.0, 6.0), Span(1.0, 3.0)], 3.0),
        ([Span(1.0, 3.0), Span(2.0, 4.0)], 3.0),
        ([Span(1.0, 9.0), Span(2.0, 3.0), Span(4.0, 5.0)], 8.0),
        ([Span(1.0, 2.0), Span(2.0, 3.0)], 2.0),
    ],
)
def test_what_overlaps_counts_once(spans: list[Span], seconds: float) -> None:
    assert covered_s(spans) == seconds
