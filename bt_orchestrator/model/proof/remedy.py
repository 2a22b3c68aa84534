"""Find, by trial, the smallest change of one flag that frees a line (semantics 8.2).

Or the probable intention, if the flag points backward.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Collection, Iterator
from dataclasses import replace

from bt_orchestrator.model.proof.operations import Operations
from bt_orchestrator.model.proof.precedence import Precedence
from bt_orchestrator.model.proof.standstill import gets_stuck
from bt_orchestrator.model.script import Dependency


def remedy(script: Operations, flags: Collection[str]) -> str:
    """Say in words what frees a script that gets stuck; empty: no change of one flag does.

    :param flags: the flags of a circle: changes of others do not break it
    """
    words = ''
    most = max(1, script.sink - script.source)  # no circle lacks more items than that
    for flag in script.flags.values():
        if flag.flag in flags:
            found = _smallest(script, flag, most)
            if found is not None:
                more, changed = found
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
    tried = ((more, one) for more in range(least, most + 1) for one in _changes(flag, more))
    return next(((more, one) for more, one in tried if _frees(script, one)), None)


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
