"""Aligned tables."""

from __future__ import annotations

from bt_orchestrator.view.report.tables import table


def test_the_first_column_is_to_the_left_and_the_others_to_the_right() -> None:
    assert list(table(('part', 'busy'), [('a', '1.0 s'), ('long name', '22.5 s')])) == [
        'part         busy',
        'a           1.0 s',
        'long name  22.5 s',
    ]


def test_a_table_without_rows_is_its_header() -> None:
    assert list(table(('a', 'b'), [])) == ['a  b']
