"""Snapshots of the inspection server as trees."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from bt_orchestrator.model.branch import Branch, Outcome

DECORATOR = 6
"""The type of a decorator in a snapshot (py_trees_ros_interfaces/msg/Behaviour.DECORATOR)."""


def tree_of(behaviours: Sequence[Any]) -> Branch | None:
    """Return the tree of a snapshot (py_trees_ros_interfaces/msg/Behaviour[])."""
    by_id = {bytes(behaviour.own_id.uuid): behaviour for behaviour in behaviours}
    parents = (bytes(behaviour.parent_id.uuid) for behaviour in behaviours)
    for behaviour, parent in zip(behaviours, parents, strict=True):
        if parent not in by_id:
            return _branch(behaviour, by_id)
    return None


def _branch(behaviour: Any, by_id: Mapping[bytes, Any]) -> Branch:
    children = (by_id[bytes(child.uuid)] for child in behaviour.child_ids)
    return Branch(
        name=behaviour.name,
        status=Outcome(behaviour.status),
        words=behaviour.message,
        is_decorator=behaviour.type == DECORATOR,
        children=tuple(_branch(child, by_id) for child in children),
    )
