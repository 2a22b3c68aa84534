"""Which tasks wait for nothing but the readiness of their component, read off the tree."""

from __future__ import annotations

from collections.abc import Iterator

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_orchestrator.tree.guards import ReadyGuard
from bt_orchestrator.tree.subject import Subject


def unready(root: Behaviour) -> Iterator[Subject]:
    """Yield the tasks whose turn it is and whose component does not say that it is ready.

    Its guard is the innermost one, so it is asked only when belt, flags and zones are fine.
    """
    for behaviour in root.iterate():
        if isinstance(behaviour, ReadyGuard) and _waits(behaviour):
            yield behaviour.subject


def _waits(guard: ReadyGuard) -> bool:
    return guard.status is Status.RUNNING and guard.decorated.status is Status.INVALID
