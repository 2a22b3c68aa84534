"""Finds in the tree the tasks that wait only for the readiness of their component."""

from __future__ import annotations

from collections.abc import Iterator

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_orchestrator.model.wait import WaitKind
from bt_orchestrator.tree.guards import ReadyGuard
from bt_orchestrator.tree.leaf import ActionLeaf
from bt_orchestrator.tree.subject import Subject


def unready(root: Behaviour) -> Iterator[Subject]:
    """Yield the tasks that could start if their component were ready.

    Its guard and the leaf are innermost, so they wait only when belt, flags and zones allow the
    task.
    """
    for behaviour in root.iterate():
        if isinstance(behaviour, (ReadyGuard, ActionLeaf)) and _waits(behaviour):
            yield behaviour.subject


def _waits(behaviour: ReadyGuard | ActionLeaf) -> bool:
    waits = behaviour.wait is not None and behaviour.wait.kind is WaitKind.READINESS
    return waits and behaviour.status is Status.RUNNING
