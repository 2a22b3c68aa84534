"""Why something does not go on, read off the tree in its own words (semantics 7.4)."""

from __future__ import annotations

from collections.abc import Iterator

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_orchestrator.tree.leaf import ActionLeaf


def waiting(behaviour: Behaviour) -> list[str]:
    """Return what a subtree waits for; nothing when all its running leaves have a goal."""
    return list(dict.fromkeys(_reasons(behaviour)))


def _reasons(behaviour: Behaviour) -> Iterator[str]:
    if behaviour.status is not Status.RUNNING:
        return
    running = [child for child in behaviour.children if child.status is Status.RUNNING]
    if not running:
        works = isinstance(behaviour, ActionLeaf) and behaviour.in_flight
        if behaviour.feedback_message and not works:
            yield behaviour.feedback_message
    for child in running:
        yield from _reasons(child)
