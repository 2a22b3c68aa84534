"""The behaviour tree as data."""

from __future__ import annotations

from py_trees.behaviour import Behaviour
from py_trees.common import Status
from py_trees.decorators import Decorator

from bt_orchestrator.model.branch import Branch, Outcome

_OUTCOMES = {
    Status.INVALID: Outcome.INVALID,
    Status.RUNNING: Outcome.RUNNING,
    Status.SUCCESS: Outcome.SUCCESS,
    Status.FAILURE: Outcome.FAILURE,
}


def branch_of(behaviour: Behaviour) -> Branch:
    """Return a behaviour with everything below it; not to be called while it is ticked."""
    active = behaviour.status is not Status.INVALID  # else the words are of its last tick
    return Branch(
        name=behaviour.name,
        status=_OUTCOMES[behaviour.status],
        words=str(behaviour.feedback_message) if active else '',
        is_decorator=isinstance(behaviour, Decorator),
        children=tuple(map(branch_of, behaviour.children)),
    )
