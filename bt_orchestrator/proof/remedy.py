"""The smallest change of one flag that frees a line, found by trying (semantics 8.2)."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Collection, Iterator
from dataclasses import replace

from bt_orchestrator.model.script import Dependency
from bt_orchestrator.proof.operations import Operations
from bt_orchestrator.proof.precedence import Precedence
from bt_orchestrator.proof.standstill import gets_stuck


def remedy(script: Operations, flags: Collection[str]) -> str:
    """Say in words what frees a script that gets stuck; empty: no change of one flag does.

    :param flags: those of a circle: whatever becomes of the others, it stays
    """
    most = max(1, script.sink - script.source)  # no circle lacks more items than that
    least = {
        flag: _least(script, flag, most) for name, flag in script.flags.items() if name in flags
    }
    for more in range(1, most + 1):
        for flag, needed in least.items():
            if needed <= more:
                for changed in _changes(flag, more):
                    if _frees(script, changed):
                        return _in_words(changed, flag)
    return ''


def _least(script: Operations, flag: Dependency, most: int) -> int:
    """Return how much more would do if it were both more room and more counts at once.

    No single change does with less. Greater than `most`: not even that frees the line.
    """

    def frees(more: int) -> bool:
        initial, capacity = flag.initial + more, flag.capacity + 2 * more
        return _frees(script, replace(flag, initial=initial, capacity=capacity))

    return 1 + bisect_left(range(1, most + 1), True, key=frees)


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
