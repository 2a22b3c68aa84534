"""Each worker begins with its share of the long tests."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from long_first import dealt


@pytest.mark.parametrize(
    ('marks', 'workers', 'order'),
    [
        ('....LL', 2, [4, 0, 1, 5, 2, 3]),
        ('..L....', 3, [2, 0, 1, 3, 4, 5, 6]),
        ('LLLLL', 2, [0, 2, 1, 3, 4]),
        ('....', 2, [0, 1, 2, 3]),
    ],
)
def test_long_tests_stand_where_a_share_begins(marks: str, workers: int, order: list[int]) -> None:
    assert dealt([mark == 'L' for mark in marks], workers) == order


@given(st.lists(st.booleans()), st.integers(1, 6))
def test_every_test_is_dealt_once(is_long: list[bool], workers: int) -> None:
    assert sorted(dealt(is_long, workers)) == list(range(len(is_long)))
