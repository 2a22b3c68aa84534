"""Finds in the tree why something waits (semantics 7.4)."""

from __future__ import annotations

from collections.abc import Iterator

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_orchestrator.model.frozen import changed
from bt_orchestrator.model.wait import Wait
from bt_orchestrator.tree.waiter import Waiter


def waits_of(behaviour: Behaviour) -> tuple[Wait, ...]:
    """Return the waits of a subtree, each once, with the components that they block.

    Empty if all its leaves have a goal.
    """
    found: dict[Wait, dict[str, None]] = {}
    for waiter in _waiters(behaviour):
        if waiter.wait is not None:
            found.setdefault(waiter.wait, {}).update(dict.fromkeys(waiter.components))
    return tuple(
        changed(wait, components=tuple(components)) if components else wait
        for wait, components in found.items()
    )


def _waiters(behaviour: Behaviour) -> Iterator[Waiter]:
    """Yield the behaviours that wait, in the order of the tree."""
    if behaviour.status is not Status.RUNNING:
        return
    running = [child for child in behaviour.children if child.status is Status.RUNNING]
    if not running and isinstance(behaviour, Waiter):
        yield behaviour
    for child in running:
        yield from _waiters(child)
