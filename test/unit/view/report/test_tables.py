"""Aligned tables."""

from __future__ import annotations

from bt_orchestrator.view.report.tables import table


def test_first_column_aligns_left_others_right() -> None:
    assert list(table(('part', 'busy'), [('a', '1.0 s'), ('long name', '22.5 s')])) == [
        'part         busy',
        'a           1.0 s',
        'long name  22.5 s',
    ]


def test_a_table_without_rows_is_its_header() -> None:
    assert list(table(('a', 'b'), [])) == ['a  b']
