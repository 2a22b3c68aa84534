"""The circle of waits in which a line stands still, in the words that the line itself would use.

Every part of the cell stands at the first thing that it cannot do, which waits for another part.
Followed from the belt on, the waits come back to a part that was met before.
"""

from __future__ import annotations

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
    """Return who waits for whom; the belt comes last, if it is one of them."""
    met: dict[int | None, Stand] = {}
    section = None
    while section not in met:
        wait = (
            _of_section(script, line, still, section) if section else _of_belt(script, line, still)
        )
        met[section] = Stand(section, wait)
        section = wait.sections[0] if wait.sections else None
    ways = list(met)
    first = ways.index(section)
    circle = ways[first:] if section else [*ways[1:], None]
    return tuple(met[part] for part in circle)


def _of_belt(script: Operations, line: Precedence, still: Standstill) -> Wait:
    """Say which turn of the beat never becomes complete."""
    number, item = next(
        (number, item)
        for number, turn in script.turns.items()
        if still.never(turn, item := line.item(turn, still.beat))
    )
    if not still.never(script.begins[number], item):
        does = f'finish with item {item}'
    elif number == script.source:
        does = 'place the next item'
    else:
        does = f'begin with item {item}'
    return Wait(f'waiting for section {number} to {does}', WaitKind.TURN, sections=(number,))


def _of_section(script: Operations, line: Precedence, still: Standstill, number: int) -> Wait:
    """Say what a section waits for: a flag, or what the belt brings."""
    operation = _stands_at(line, still, number)
    item = still.first_never[operation]
    for relation in reversed(line.before[operation]):
        flag, other = relation.dependency, relation.before
        if flag is not None and still.never(other, item - relation.items):
            does = 'take' if operation.task == flag.upstream else 'set'
            what = f'waiting for {other.task} to {does} flag {flag.flag}'
            return Wait(what, WaitKind.FLAG, flag.flag, (other.section,), other.task)
    if number == script.source or (item > 1 and number != script.sink):
        return Wait('waiting for the belt to move', WaitKind.BELT)
    return Wait('waiting for an item', WaitKind.ITEM)


def _stands_at(line: Precedence, still: Standstill, number: int) -> Operation:
    """Return the first thing that a section cannot do, although its list would let it."""
    return min(
        (item, operation)
        for operation, item in still.first_never.items()
        if operation.section == number and not _waits_in_list(line, still, operation, item)
    )[1]


def _waits_in_list(line: Precedence, still: Standstill, operation: Operation, item: int) -> bool:
    return any(
        still.never(relation.before, item - relation.items)
        for relation in line.before[operation]
        if relation.dependency is None
    )
