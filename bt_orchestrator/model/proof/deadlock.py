"""The proof that scripts cannot get stuck, and the refusal of those that can (semantics 8.2).

By 3.2, 4.1, 4.2 and 5.2 data never changes the flag and belt operations, and durations only change
when they happen, not whether. So the order relations are the same in every run, and decide without
one; docs/deadlock_proof.md has the argument and its conditions.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

from bt_orchestrator.model.proof.precedence import Operation, Operations, Precedence
from bt_orchestrator.model.proof.standstill import Standstill, first_standstill, gets_stuck
from bt_orchestrator.model.script import Dependency, Script
from bt_orchestrator.model.wait import Wait, WaitKind


@dataclass(frozen=True)
class Deadlock:
    """How a script gets stuck."""

    script: str
    item: int
    """The last item that the source can begin, counted from 1."""
    beat: int
    """The beat that the belt cannot end."""
    circle: tuple[Stand, ...]
    remedy: str
    """The smallest change of one flag that frees the line; empty: there is none."""
    swapped: str = ''
    """Flag whose ends look swapped; empty: none."""

    @property
    def flags(self) -> tuple[str, ...]:
        """Flags that are waited for in the circle."""
        return _flags_in(self.circle)

    @property
    def hint(self) -> str:
        """The remedy."""
        counts = self.remedy or 'no larger capacity or initial count of one flag frees it'
        if not self.swapped:
            return counts
        return f'swap `upstream` and `downstream` of flag {self.swapped}; or {counts}'

    def __str__(self) -> str:
        waits = '; '.join(map(str, self.circle))
        return (
            f'the line gets stuck with {self.script}, at item {self.item} in beat {self.beat}: '
            f'{waits}'
        )


def deadlock(script: Script) -> Deadlock | None:
    """Return how a script gets stuck; None: it is proven that it cannot."""
    if not script.dependencies:
        return None  # everything waits only for the belt, and the belt for what always ends
    operations = Operations(script)
    line = Precedence([operations])
    still = first_standstill(line)
    if still is None:
        return None
    circle = circle_of_waits(operations, line, still)
    return Deadlock(
        script=script.name,
        item=still.first_never[operations.begins[operations.source]] - 1,
        beat=still.beat,
        circle=circle,
        remedy=remedy(operations, _flags_in(circle)),
        swapped=swapped(operations, _flags_in(circle)),
    )


def get_stuck_together(scripts: Iterable[Script]) -> bool:
    """Tell whether jobs of these scripts can get stuck only behind each other.

    Scripts that share no flag cannot.
    """
    operations: list[Operations] = []
    for script in scripts:
        if script.dependencies:
            operations.append(Operations(script, sum(len(entry.all) for entry in operations)))
    if len(operations) < 2 or any(gets_stuck(Precedence([entry])) for entry in operations):
        return False
    return gets_stuck(Precedence(operations))


def _flags_in(circle: tuple[Stand, ...]) -> tuple[str, ...]:
    return tuple(stand.wait.name for stand in circle if stand.wait.kind is WaitKind.FLAG)


# The circle of waits in a deadlocked line, in the words of the running line.
#
# Every part of the cell is blocked by something that waits for another part, or for another track
# of the same group. Followed from the belt, the waits return to an earlier place.


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


# Find, by trial, the smallest change of one flag that frees a line (semantics 8.2).
#
# Or the probable intention, if the flag points backward.


def remedy(script: Operations, flags: Collection[str]) -> str:
    """Say in words what frees a script that gets stuck; empty: no change of one flag does.

    :param flags: the flags of a circle: changes of others do not break it
    """
    words = ''
    most = max(1, script.sink - script.source)  # no circle lacks more items than that
    for flag in script.flags.values():
        if flag.flag in flags:
            change = _smallest(script, flag, most)
            if change is not None:
                more, changed = change
                words, most = _in_words(changed, flag), more - 1
    return words


def swapped(script: Operations, flags: Collection[str]) -> str:
    """Return the flag whose ends look swapped; empty: none does.

    Its downstream task comes first for every item, its initial count is 0, and with its ends
    swapped the script does not get stuck.
    """
    for flag in script.flags.values():
        up, down = script.of_task[flag.upstream], script.of_task[flag.downstream]
        turned = replace(flag, upstream=flag.downstream, downstream=flag.upstream)
        is_backward = down.number < up.number and not flag.initial
        if flag.flag in flags and is_backward and _frees(script, turned):
            return flag.flag
    return ''


def _smallest(script: Operations, flag: Dependency, most: int) -> tuple[int, Dependency] | None:
    """Return the smallest change of a flag that frees the script, and the changed flag.

    No change of room or count alone frees it below the amount at which both together would.
    """

    def does(more: int) -> bool:
        initial, capacity = flag.initial + more, flag.capacity + 2 * more
        return _frees(script, replace(flag, initial=initial, capacity=capacity))

    if not does(most):
        return None
    least = 1 + bisect_left(range(1, most), True, key=does)
    tried = (
        (more, dependency)
        for more in range(least, most + 1)
        for dependency in _changes(flag, more)
    )
    return next(
        ((more, dependency) for more, dependency in tried if _frees(script, dependency)), None
    )


def _changes(flag: Dependency, more: int) -> Iterator[Dependency]:
    yield replace(flag, capacity=flag.capacity + more)
    initial = flag.initial + more
    yield replace(flag, initial=initial, capacity=max(flag.capacity, initial))


def _frees(script: Operations, changed: Dependency) -> bool:
    return not gets_stuck(Precedence([script.changed(changed)]))


def _in_words(changed: Dependency, before: Dependency) -> str:
    flag = f'of flag {changed.flag} frees it'
    if changed.initial == before.initial:
        return f'capacity {changed.capacity} {flag}'
    if changed.capacity == before.capacity:
        return f'initial count {changed.initial} {flag}'
    return f'initial count {changed.initial} with capacity {changed.capacity} {flag}'
