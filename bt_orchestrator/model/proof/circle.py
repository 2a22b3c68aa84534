"""The circle of waits in a deadlocked line, in the words of the running line.

Every part of the cell is blocked by something that waits for another part, or for another track of
the same group. Followed from the belt, the waits return to an earlier place.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from bt_orchestrator.model.proof.operations import Operation, Operations
from bt_orchestrator.model.proof.precedence import Precedence
from bt_orchestrator.model.proof.standstill import Standstill
from bt_orchestrator.model.wait import Wait, WaitKind


class Stand(NamedTuple):
    """One blocked part of the cell, and what it waits for."""

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
    """Return the shortest circle of waits; the belt, if it is in it, comes last."""
    return min(
        (_circle(script, line, still, *turn) for turn in _of_belt(script, line, still)), key=len
    )


def _circle(
    script: Operations, line: Precedence, still: Standstill, wait: Wait, turn: Operation
) -> tuple[Stand, ...]:
    """Follow the waits, starting with a turn the belt waits for, until a place repeats.

    A place is the belt or an operation: the tracks of a group are at several.
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
    """Yield the turns of the beat that are never completed, with the belt's waits for them."""
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
    """Return the first blocked operation of a list up to this one."""
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
    """Say what an operation waits for: a flag and its task, or the move of the belt."""
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
