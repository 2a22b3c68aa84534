"""Whether a line comes to a standstill, and where, derived from the order relations.

An operation never happens if it must come after one that never happens. So a line gets stuck
exactly if a move of the belt must come after itself, or an operation after itself for the same
item; docs/deadlock_proof.md has the argument.
"""

from __future__ import annotations

import heapq
from collections.abc import Collection, Mapping
from contextlib import suppress
from graphlib import CycleError, TopologicalSorter
from typing import NamedTuple

from bt_orchestrator.model.proof.precedence import Operation, Precedence


class Standstill(NamedTuple):
    """How far a line gets if its source always has items."""

    beat: int
    """The belt does not move at the end of this one."""
    first_never: Mapping[Operation, int]
    """The first item, counted from 1, for which an operation cannot happen."""

    def never(self, operation: Operation, item: int) -> bool:
        """Tell whether an operation cannot happen for an item."""
        first = self.first_never.get(operation)
        return first is not None and item >= first


def gets_stuck(line: Precedence) -> bool:
    """Tell whether a line ever comes to a standstill."""
    return bool(_knots(line)) or _last_beat(line, _follow(line, line.length, ())) <= line.length


def first_standstill(line: Precedence) -> Standstill | None:
    """Return where a line comes to a standstill; None: nowhere."""
    if not gets_stuck(line):
        return None
    knots = _knots(line)
    beat, first_never = 0, _follow(line, 1, knots)
    while (last := _last_beat(line, first_never)) > beat:
        beat, first_never = last, _follow(line, last, knots)
    return Standstill(beat, first_never)


def _knots(line: Precedence) -> set[Operation]:
    """Return operations that must follow themselves for the same item, and their successors."""
    order: TopologicalSorter[Operation] = TopologicalSorter()
    for operation in line.operations:
        order.add(
            operation,
            *(relation.before for relation in line.before[operation] if not relation.items),
        )
    knots = set(line.operations)
    with suppress(CycleError):
        order.prepare()
    while possible := order.get_ready():
        knots.difference_update(possible)
        order.done(*possible)
    return knots


def _follow(line: Precedence, beat: int, knots: Collection[Operation]) -> dict[Operation, int]:
    """Return, by operation, the first item for which it must come after the end of a beat.

    Dijkstra's algorithm, with items as distances.

    :param knots: operations that never happen at all
    """
    pending = [(1, operation) for operation in knots]
    pending += [
        (max(1, line.item(operation, beat + 1)), operation)
        for operation in line.operations
        if operation.follows_move
    ]
    heapq.heapify(pending)
    first_items: dict[Operation, int] = {}
    while pending:
        item, operation = heapq.heappop(pending)
        if operation in first_items:
            continue
        first_items[operation] = item
        for relation in line.after[operation]:
            if relation.after not in first_items:
                heapq.heappush(pending, (item + relation.items, relation.after))
    return first_items


def _last_beat(line: Precedence, first_never: Mapping[Operation, int]) -> int:
    """Return the first beat whose end must come after a turn that is never completed."""
    return min(line.beat(turn, first_never[turn]) for turn in line.turns)
