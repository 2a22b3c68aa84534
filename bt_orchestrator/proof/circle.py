"""The circle of waits in which a line stands still, in the words that the line itself would use.

Every part of the cell stands at the first thing that it cannot do, which waits for another part.
Followed from the belt on, the waits come back to a part that was met before.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
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
    standing = _standing(line, still).items()
    sections = {number: Stand(number, _wait(script, line, still, at)) for number, at in standing}
    turns = _of_belt(script, line, still)
    return min((_circle(Stand(None, turn), sections) for turn in turns), key=len)


def _circle(belt: Stand, sections: Mapping[int, Stand]) -> tuple[Stand, ...]:
    """Follow the waits, from one of the belt's on, until a part comes back."""
    met: dict[int | None, Stand] = {}
    stand = belt
    while stand.section not in met:
        met[stand.section] = stand
        stand = sections[stand.wait.sections[0]] if stand.wait.sections else belt
    ways = list(met.values())
    circle = ways[ways.index(stand) :]
    return (*circle[1:], belt) if stand is belt else tuple(circle)


def _of_belt(script: Operations, line: Precedence, still: Standstill) -> Iterator[Wait]:
    """Yield which turns of the beat never become complete."""
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
        yield Wait(what, WaitKind.TURN, sections=(number,))


def _standing(line: Precedence, still: Standstill) -> dict[int, Operation]:
    """Return the first thing that each section cannot do, although its list would let it."""
    found: dict[int, Operation] = {}
    for operation, item in sorted(still.first_never.items(), key=lambda one: (one[1], one[0])):
        if operation.section not in found and not _waits_in_list(line, still, operation, item):
            found[operation.section] = operation
    return found


def _waits_in_list(line: Precedence, still: Standstill, operation: Operation, item: int) -> bool:
    return any(
        still.never(relation.before, item - relation.items)
        for relation in line.before[operation]
        if relation.dependency is None
    )


def _wait(script: Operations, line: Precedence, still: Standstill, operation: Operation) -> Wait:
    """Say what an operation waits for: a flag, or what the belt brings."""
    item = still.first_never[operation]
    for relation in reversed(line.before[operation]):
        flag, other = relation.dependency, relation.before
        if flag is not None and still.never(other, item - relation.items):
            does = 'take' if operation.task == flag.upstream else 'set'
            what = f'waiting for {other.task} to {does} flag {flag.flag}'
            return Wait(what, WaitKind.FLAG, flag.flag, (other.section,), other.task)
    if operation.section == script.source or (item > 1 and operation.section != script.sink):
        return Wait('waiting for the belt to move', WaitKind.BELT)
    return Wait('waiting for an item', WaitKind.ITEM)
