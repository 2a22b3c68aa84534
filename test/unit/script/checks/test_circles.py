"""Circles in a graph of waits."""

from __future__ import annotations

import pytest

from bt_orchestrator.script.checks.structure import circles


@pytest.mark.parametrize(
    ('edges', 'expected'),
    [
        ('', []),
        ('ab bc ac', []),
        ('ab ba', ['aba']),
        ('aa', ['aa']),
        ('xa ab bc ca', ['abca']),
        ('ab ba cd dc', ['aba', 'cdc']),
        ('ab bc ca cb', ['abca']),
        ('ab ac cd db', []),
    ],
)
def test_circles(edges: str, expected: list[str]) -> None:
    cycles = circles((edge[0], edge[1]) for edge in edges.split())
    assert [''.join(circle) for circle in cycles] == expected


def test_a_long_way_is_walked_without_recursion() -> None:
    way = [(str(number), str(number + 1)) for number in range(3000)]
    assert circles(way) == []
    assert len(circles([*way, ('3000', '0')])[0]) == 3002
