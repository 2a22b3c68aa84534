"""Reasons of the holds under which nothing starts anywhere, and how each ends (semantics 7.3)."""

from __future__ import annotations

PAUSED = 'paused'
"""An operator paused the cell."""
RESTARTED = 'restarted'
"""An orchestrator has taken over unfinished work."""
RESTORED = 'restored'
"""The journal was restored from a backup: the line may be ahead of it."""
MISSING = 'missing'
"""Written events are lost from the journal: the line is ahead of it."""
TWIN = 'twin'
"""Another node answers under the name of this one."""
UNKNOWN_GOAL = 'unknown_goal'
"""At a take-over a server runs a goal unknown to the journal: the journal is incomplete."""

NAMED = frozenset((RESTARTED, RESTORED, MISSING, TWIN, UNKNOWN_GOAL))
"""An operator has to check the line first, so these are released only by the hold's name."""


def release_command(hold: str) -> str:
    """Return the command that releases one hold of any owner."""
    return f'bt-orchestrator cell resume --hold {hold} --reason WHY'
