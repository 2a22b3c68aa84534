"""Reasons of the holds under which nothing starts anywhere, and how each ends (semantics 7.3)."""

from __future__ import annotations

PAUSED = 'paused'
"""An operator paused the cell."""
RESTARTED = 'restarted'
"""An orchestrator has taken over unfinished work."""
RESTORED = 'restored'
"""The journal was brought back from a backup: the line may be further than it says."""
MISSING = 'missing'
"""Events that were written are not in the journal any more: the line is further than it says."""
TWIN = 'twin'
"""Another node answers under the name of this one."""
UNKNOWN_GOAL = 'unknown_goal'
"""At a take-over a server runs a goal that the journal does not know: it is not all there was."""

NAMED = frozenset((RESTARTED, RESTORED, MISSING, TWIN, UNKNOWN_GOAL))
"""Somebody has to look at the line first, so these are released only by naming the hold."""


def release_command(hold: str) -> str:
    """Return what to type to release one hold, whoever's it is."""
    return f'bt-orchestrator resume --hold {hold} --reason WHY'
