"""The circle of waits in which a line stands still, in the words that the line itself would use.

Every part of the cell stands at something that it cannot do, which waits for another part, or for
another track of the same group. Followed from the belt on, the waits come back to a place that was
met before.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from bt_orchestrator.model.wait import Wait, WaitKind
from bt_orchestrator.proof.operations import Operation, Operations
from bt_orchestrator.proof.precedence import Precedence
from bt_orchestrator.proof.standstill import Standstill


class Stand(NamedTuple):
    """One part of the cell that stands still, and what for."""

    section: int | None
    """None: it is the belt."""
    wait: Wait

    @property
    def part(self) -> str:
        """Its name."""
        return 'belt' if self.section is None else f'section {self.section}'

    def __str__(self) -> str:
        return f'{self.part} is {self.wait}'


def circle_of_waits(script: Operations, line: Precedence, still: Standstill) -> tuple[Stand, ...]:
    """Return the shortest circle of who waits for whom; the belt, if it is in it, comes last."""
    return min(
        (_circle(script, line, still, *turn) for turn in _of_belt(script, line, still)), key=len
    )


def _circle(
    script: Operations, line: Precedence, still: Standstill, wait: Wait, turn: Operation
) -> tuple[Stand, ...]:
    """Follow the waits, from one of the belt's for a turn on, until a place comes back.

    A place is the belt or an operation: the tracks of a group stand at several.
    """
    belt = Stand(None, wait)
    met: dict[Operation | None, Stand] = {None: belt}
    place: Operation | None = _standing(line, still, turn)
    while place is not None and place not in met:
        wait, missing = _wait(script, line, still, place)
        met[place] = Stand(place.section, wait)
        place = _standing(line, still, missing) if missing is not None else None
    stands = list(met.values())
    circle = stands[stands.index(met[place]) :]
    return (*circle[1:], belt) if place is None else tuple(circle)


def _of_belt(
    script: Operations, line: Precedence, still: Standstill
) -> Iterator[tuple[Wait, Operation]]:
    """Yield which turns of the beat never become complete, with the waits for them."""
    for number, turn in script.turns.items():
        item = line.item(turn, still.beat)
        if not still.never(turn, item):
            continue
        if not still.never(script.begins[number], item):
            does = f'finish with item {item}'
        elif number == script.source:
            does = 'place the next item'
        else:
            does = f'begin with item {item}'
        what = f'waiting for section {number} to {does}'
        yield Wait(what, WaitKind.TURN, sections=(number,)), turn


def _standing(line: Precedence, still: Standstill, operation: Operation) -> Operation:
    """Return what an operation waits for in its list, which the list itself would let happen."""
    while (before := _before_in_list(line, still, operation)) is not None:
        operation = before
    return operation


def _before_in_list(line: Precedence, still: Standstill, operation: Operation) -> Operation | None:
    item = still.first_never[operation]
    missing = (
        relation.before
        for relation in line.before[operation]
        if relation.dependency is None and still.never(relation.before, item - relation.items)
    )
    return next(missing, None)


def _wait(
    script: Operations, line: Precedence, still: Standstill, operation: Operation
) -> tuple[Wait, Operation | None]:
    """Say what an operation waits for: a flag, and for whom; or what the belt brings."""
    item = still.first_never[operation]
    for relation in reversed(line.before[operation]):
        flag, other = relation.dependency, relation.before
        if flag is not None and still.never(other, item - relation.items):
            does = 'take' if operation.task == flag.upstream else 'set'
            what = f'waiting for {other.task} to {does} flag {flag.flag}'
            return Wait(what, WaitKind.FLAG, flag.flag, (other.section,), other.task), other
    if operation.section == script.source or (item > 1 and operation.section != script.sink):
        return Wait('waiting for the belt to move', WaitKind.BELT), None
    return Wait('waiting for an item', WaitKind.ITEM), None
