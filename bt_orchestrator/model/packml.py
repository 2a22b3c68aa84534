"""The states of the cell, after PackML (ISA-TR88.00.02; semantics 7.2)."""

from __future__ import annotations

from enum import Enum


class Mode(Enum):
    """State of the cell."""

    STOPPED = 'Stopped'
    RESETTING = 'Resetting'
    IDLE = 'Idle'
    STARTING = 'Starting'
    EXECUTE = 'Execute'
    COMPLETING = 'Completing'
    COMPLETE = 'Complete'
    HOLDING = 'Holding'
    HELD = 'Held'
    UNHOLDING = 'Unholding'
    STOPPING = 'Stopping'

    @property
    def begins(self) -> bool:
        """Tell whether cycles, index moves and initialization may begin."""
        return self is Mode.EXECUTE

    @property
    def works(self) -> bool:
        """Tell whether cycles in hand go on (semantics 7.1: a hold lets them finish)."""
        return self in (Mode.EXECUTE, Mode.HOLDING, Mode.HELD, Mode.UNHOLDING)


NEXT = {
    Mode.STOPPED: (Mode.RESETTING,),
    Mode.RESETTING: (Mode.IDLE, Mode.STOPPING),
    Mode.IDLE: (Mode.STARTING, Mode.STOPPING),
    Mode.STARTING: (Mode.EXECUTE, Mode.HOLDING, Mode.STOPPING),
    Mode.EXECUTE: (Mode.COMPLETING, Mode.HOLDING, Mode.STOPPING),
    Mode.COMPLETING: (Mode.COMPLETE, Mode.STOPPING),
    Mode.COMPLETE: (Mode.RESETTING, Mode.STOPPING),
    Mode.HOLDING: (Mode.HELD, Mode.UNHOLDING, Mode.STOPPING),
    Mode.HELD: (Mode.UNHOLDING, Mode.STOPPING),
    Mode.UNHOLDING: (Mode.EXECUTE, Mode.HOLDING, Mode.STOPPING),
    Mode.STOPPING: (Mode.STOPPED,),
}
"""Which state may follow which."""
