"""Which lines stay where there is no room for all."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from bt_orchestrator.view.screen.fit import heights, stay


def test_heights_meet_minimums_then_serve_first_parts() -> None:
    assert heights([5, 30, 4], [2, 3, 1], 20) == [5, 14, 1]
    assert heights([5, 30, 4], [2, 3, 1], 100) == [5, 30, 4]
    assert heights([5, 30, 4], [2, 3, 1], 4) == [2, 2, 0]


@given(st.lists(st.tuples(st.integers(0, 40), st.integers(0, 6)), max_size=6), st.integers(0, 60))
def test_room_is_used_and_never_overdrawn(parts: list[tuple[int, int]], room: int) -> None:
    wanted, least = [want for want, _ in parts], [small for _, small in parts]
    result = heights(wanted, least, room)
    assert all(0 <= got <= want for got, want in zip(result, wanted, strict=True))
    assert sum(result) == min(room, sum(wanted))


def test_the_lightest_stay_in_their_order() -> None:
    assert stay([3, 0, 2, 0, 1], 4) == [1, 3, 4]
    assert stay([3, 0, 2, 0, 1], 5) == [0, 1, 2, 3, 4]
    assert stay([1, 1], 0) == []
