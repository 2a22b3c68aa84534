"""Why the line stands still: one recorded reason, from which both vocabularies follow.

PackML and ISA-95 mean nearly opposite things by Held and Suspended, so neither is ever derived
from the other (semantics 7.2).
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from typing import NamedTuple

from bt_orchestrator.model.packml import Cause


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
