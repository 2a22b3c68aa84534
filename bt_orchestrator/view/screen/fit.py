"""Room on a terminal: which lines are shown if not all of them fit."""

from __future__ import annotations

from collections.abc import Sequence


def heights(wanted: Sequence[int], least: Sequence[int], room: int) -> list[int]:
    """Return how many lines each part gets.

    First every part gets the least that it asks for, then, in order, what it wants; so the order
    of the parts is that of their importance.
    """
    given = []
    for want, small in zip(wanted, least, strict=True):
        given.append(min(want, small, room))
        room -= given[-1]
    for number, want in enumerate(wanted):
        more = min(want - given[number], room)
        given[number] += more
        room -= more
    return given


def stay(weights: Sequence[int], room: int) -> list[int]:
    """Return the places of the rows that stay, in their order: the lightest, the first of equals.

    Where some must go, one line of the room is left for the words about them.
    """
    if len(weights) <= room:
        return list(range(len(weights)))
    by_weight = sorted(range(len(weights)), key=lambda place: (weights[place], place))
    return sorted(by_weight[: max(room - 1, 0)])
