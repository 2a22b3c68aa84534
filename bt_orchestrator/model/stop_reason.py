"""Why the line stands still: one recorded reason, wishes to stop, holds that pause everything.

PackML and ISA-95 mean nearly opposite things by Held and Suspended, so neither is ever derived
from the other (semantics 7.2).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from bt_orchestrator.model.by import named
from bt_orchestrator.model.packml import VERBS, Cause, PackmlState, UnitMode


class StopReason(Enum):
    """Why the line stands still."""

    OPERATOR = 'operator'
    """Requested by a person: a pause, or a stop."""
    OWN_FAULT = 'own_fault'
    """A task or an item waits for an answer, or the orchestrator was restarted in the middle."""
    STARVED = 'starved'
    """The source is not ready, and everything else waits."""
    BLOCKED = 'blocked'
    """The sink is not ready, and everything else waits."""
    EMERGENCY = 'emergency'
    """`abort` was commanded, and the belt was not confirmed since."""


class Interruption(Enum):
    """The ISA-95 Job Control state of a started job that is interrupted."""

    HELD = 'Held'
    SUSPENDED = 'Suspended'


class Words(NamedTuple):
    """A stop reason in both vocabularies."""

    cell: Cause
    """Its PackML command for the cell."""
    job: Interruption
    """Its state for the jobs on the line."""


WORDS: Mapping[StopReason, Words] = {
    StopReason.OPERATOR: Words(Cause.HOLD, Interruption.SUSPENDED),
    StopReason.OWN_FAULT: Words(Cause.HOLD, Interruption.HELD),
    StopReason.STARVED: Words(Cause.SUSPEND, Interruption.HELD),
    StopReason.BLOCKED: Words(Cause.SUSPEND, Interruption.HELD),
    StopReason.EMERGENCY: Words(Cause.ABORT, Interruption.HELD),
}


# An operator's request to stop the cell, valid until an operator starts it (semantics 7.2).

STOP_AFTER = 'stop_after_'
"""Prefix of the commands that first run the line empty; `item` or `job` follows."""

AFTER, NEVER = ('item', 'job'), 'never'
"""When the line stops accepting work, and the word that withdraws the request."""

START = VERBS[Cause.START]
STAND = (
    *(VERBS[cause] for cause in (Cause.STOP, Cause.ABORT, Cause.CLEAR)),
    *(mode.value for mode in UnitMode),
)
"""Commands after which only an operator's `start` moves the cell."""


@dataclass(frozen=True)
class Wish:
    """An operator's request that the cell stops."""

    command: str
    """As it is recorded: stop, abort, clear, manual, production, stop_after_item or
    stop_after_job."""
    who: str = ''
    """Empty: not known."""
    reason: str = ''
    time: float = 0.0
    """Time of the request, seconds; 0: not known."""
    known: str = ''
    """How the sender is known (`model.by`); empty: not known."""

    def __str__(self) -> str:
        return self.words()

    def words(self, clock: str = '') -> str:
        """Say who wants what, and why.

        :param clock: when it was said, by the reader's clock
        """
        at = f' at {clock}' if clock else ''
        why = f': {self.reason}' if self.reason else ''
        return f'{named(self.who, self.known)} said {self.command.replace("_", " ")}{at}{why}'


def way_to_work(mode: PackmlState) -> str:
    """Return the commands that bring a stopped or stopping cell back to work."""
    if mode in (PackmlState.RESETTING, PackmlState.IDLE):
        return 'start'
    return 'clear, reset and start' if mode in _ABORTED else 'reset and start'


_ABORTED = (PackmlState.ABORTING, PackmlState.ABORTED)


# Reasons of the holds under which nothing starts anywhere, and how each ends (semantics 7.3).

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

TOO_MANY_REJECTS = 'too_many_rejects'
"""Too many items in a row were rejected (semantics 7.7); cycles in hand go on to their ends."""

SAFETY = 'safety'
"""The safety input was lost while no goal was in flight (semantics 7.9)."""

UNSEEN = frozenset((RESTARTED, RESTORED, MISSING, TWIN, UNKNOWN_GOAL, SAFETY))
"""The cell may have been changed unseen, so no setup is known any more (semantics 5.3)."""

NAMED = UNSEEN | {TOO_MANY_REJECTS}
"""An operator has to check the line first, so these are released only by the hold's name."""


def release_command(hold: str) -> str:
    """Return the command that releases one hold of any owner."""
    return f'bt-orchestrator cell resume --hold {hold} --reason WHY'
