"""Where tasks stand, and what that says about their order."""

from __future__ import annotations

import pytest

from bt_orchestrator.script.drafts import Position


@pytest.mark.parametrize(
    ('first', 'second', 'precedes', 'is_beside'),
    [
        ((1, 5, 0, 0), (2, 0, 0, 0), True, False),
        ((2, 0, 0, 0), (1, 5, 0, 0), False, False),
        ((1, 0, 1, 3), (1, 1, 0, 0), True, False),
        ((1, 0, 0, 0), (1, 0, 0, 1), True, False),
        ((1, 0, 0, 1), (1, 0, 0, 0), False, False),
        ((1, 0, 0, 0), (1, 0, 1, 1), False, True),
        ((1, 0, 0, 0), (1, 0, 0, 0), False, False),
    ],
)
def test_order_of_positions(
    first: tuple[int, int, int, int],
    second: tuple[int, int, int, int],
    precedes: bool,
    is_beside: bool,
) -> None:
    assert Position(*first).precedes(Position(*second)) is precedes
    assert Position(*first).is_beside(Position(*second)) is is_beside
