"""The circle of a graph that weighs most for its length: the maximum cycle ratio.

Weights and lengths are whole numbers, so the result is exact, and the same in every run.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import NamedTuple


class Arc(NamedTuple):
    """A way from one node to another."""

    start: int
    end: int
    weight: int
    length: int
    tasks: tuple[str, ...] = ()
    """The parts of its weight."""
    flag: str = ''
    """The flag it stands for; empty: none."""


def slowest_circle(nodes: int, arcs: Sequence[Arc]) -> list[Arc]:
    """Return a circle with the largest weight for its length; empty: no circle has weight.

    Each round finds a slower circle than the last one, until there is none. All circles have
    positive lengths.

    :param nodes: how many; they are numbered from 0
    """
    # Arcs in an order in which a way that seldom turns back is followed to its end at once.
    forth = sorted((arc for arc in arcs if arc.start <= arc.end), key=lambda arc: arc.start)
    back = sorted((arc for arc in arcs if arc.start > arc.end), key=lambda arc: -arc.start)
    ordered, far = (*forth, *back), [0] * nodes
    slowest: list[Arc] = []
    scale = 1
    while slower := _slower(ordered, ratio(slowest), far):
        slowest = slower
        before, scale = scale, ratio(slowest).denominator
        far = [distance * scale // before for distance in far]
    return slowest


def ratio(circle: Sequence[Arc]) -> Fraction:
    """Return the weight of a circle for its length."""
    return Fraction(sum(a.weight for a in circle), sum(a.length for a in circle) or 1)


def _slower(arcs: Sequence[Arc], than: Fraction, far: list[int]) -> list[Arc]:
    """Return a circle of a larger ratio; empty: there is none.

    Bellman and Ford's algorithm: such a circle gains each time around, and then shows among the
    arcs by which the nodes were reached last.

    :param far: how far each node is found to be; any numbers do, those of the last round help
    """
    gains = [
        (a.start, a.end, a.weight * than.denominator - a.length * than.numerator, a) for a in arcs
    ]
    reached_by: dict[int, Arc] = {}
    changed = True
    while changed:
        changed = False
        for start, end, gain, arc in gains:
            if far[start] + gain > far[end]:
                far[end], reached_by[end], changed = far[start] + gain, arc, True
        if circles := list(_circles(reached_by)):
            return max(circles, key=ratio)
    return []


def _circles(reached_by: Mapping[int, Arc]) -> Iterator[list[Arc]]:
    """Yield the circles of arcs that are the last ones to their nodes."""
    seen_from: dict[int, int] = {}
    for first in reached_by:
        node = first
        while node in reached_by and node not in seen_from:
            seen_from[node] = first
            node = reached_by[node].start
        if seen_from.get(node) == first:
            yield _back_to(node, reached_by)


def _back_to(node: int, reached_by: Mapping[int, Arc]) -> list[Arc]:
    """Return the arcs from a node of a circle to itself."""
    circle = [reached_by[node]]
    while circle[-1].start != node:
        circle.append(reached_by[circle[-1].start])
    return circle[::-1]
