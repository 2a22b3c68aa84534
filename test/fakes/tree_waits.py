"""What the tree says that it waits for: a second opinion about the teller of waits."""

from __future__ import annotations

from collections.abc import Iterator

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_orchestrator.engine.tree.subject import Waiter
from bt_orchestrator.model.wait import Wait


def waits_of(behaviour: Behaviour) -> tuple[Wait, ...]:
    """Return the waits of a subtree, each once; none if all its leaves have a goal."""
    return tuple(dict.fromkeys(_waits(behaviour)))


def _waits(behaviour: Behaviour) -> Iterator[Wait]:
    """Yield what the behaviours wait for, in the order of the tree."""
    if behaviour.status is not Status.RUNNING:
        return
    running = [child for child in behaviour.children if child.status is Status.RUNNING]
    if not running and isinstance(behaviour, Waiter) and behaviour.wait is not None:
        yield behaviour.wait
    for child in running:
        yield from _waits(child)
