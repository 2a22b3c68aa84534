"""The states of the cell and their transitions, after PackML (ISA-TR88.00.02; semantics 7.2).

One table. Code asks it, documentation prints it, and tests walk through it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
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
    SUSPENDING = 'Suspending'
    SUSPENDED = 'Suspended'
    UNSUSPENDING = 'Unsuspending'
    STOPPING = 'Stopping'
    ABORTING = 'Aborting'
    ABORTED = 'Aborted'
    CLEARING = 'Clearing'

    @property
    def begins(self) -> bool:
        """Tell whether cycles, index moves and initialization may begin.

        Suspended forbids nothing: it says that the line waits for its source or sink, and ends
        when anything can start.
        """
        return self in _BEGIN

    @property
    def works(self) -> bool:
        """Tell whether cycles in hand go on (semantics 7.1: a hold lets them finish)."""
        return self in _WORK


_BEGIN = (Mode.EXECUTE, Mode.SUSPENDING, Mode.SUSPENDED, Mode.UNSUSPENDING)
_WORK = (*_BEGIN, Mode.HOLDING, Mode.HELD, Mode.UNHOLDING, Mode.STOPPING)

MEANINGS: Mapping[Mode, str] = {
    Mode.STOPPED: (
        'nothing runs, nothing starts; waits for `reset`, or, if nobody stopped it, for an order'
    ),
    Mode.RESETTING: 'gets ready to start',
    Mode.IDLE: 'ready; waits for `start`, or, if nobody stopped it, for an order',
    Mode.STARTING: 'begins to work',
    Mode.EXECUTE: 'works',
    Mode.COMPLETING: 'the last job has ended',
    Mode.COMPLETE: 'every job has ended; waits for `reset`, or for an order',
    Mode.HOLDING: 'something is held: what runs goes on to its end, no cycle begins',
    Mode.HELD: 'something is held, and nothing runs: waits for people',
    Mode.UNHOLDING: 'goes back to work',
    Mode.SUSPENDING: 'nothing can start because source or sink is not ready',
    Mode.SUSPENDED: 'waits for the source or the sink; goes on by itself',
    Mode.UNSUSPENDING: 'goes back to work',
    Mode.STOPPING: 'finishes the cycles in hand; at the end of the node: cancels every goal',
    Mode.ABORTING: 'every goal is being cancelled; their ends are awaited',
    Mode.ABORTED: 'nothing moves; waits for `clear`',
    Mode.CLEARING: 'takes over what the operator said of the belt',
}
"""What each state means, for people."""


class Cause(Enum):
    """What makes the cell change its state: a PackML command, or that a state is through."""

    RESET = 'reset'
    START = 'start'
    HOLD = 'hold'
    UNHOLD = 'unhold'
    SUSPEND = 'suspend'
    UNSUSPEND = 'unsuspend'
    STOP = 'stop'
    ABORT = 'abort'
    CLEAR = 'clear'
    DONE = 'done'
    """What the state is there for is done (PackML: state complete)."""


_AT_WORK = (
    Mode.STARTING,
    Mode.EXECUTE,
    Mode.UNHOLDING,
    Mode.SUSPENDING,
    Mode.SUSPENDED,
    Mode.UNSUSPENDING,
)
_ABORTED = (Mode.ABORTING, Mode.ABORTED)
_STOPPED = (Mode.STOPPING, Mode.STOPPED, Mode.CLEARING, *_ABORTED)


def _all_but(modes: Iterable[Mode]) -> tuple[Mode, ...]:
    return tuple(mode for mode in Mode if mode not in modes)


_ROWS: tuple[tuple[tuple[Mode, ...], Cause, Mode], ...] = (
    ((Mode.STOPPED, Mode.COMPLETE), Cause.RESET, Mode.RESETTING),
    ((Mode.RESETTING,), Cause.DONE, Mode.IDLE),
    ((Mode.IDLE,), Cause.START, Mode.STARTING),
    ((Mode.STARTING,), Cause.DONE, Mode.EXECUTE),
    ((Mode.EXECUTE,), Cause.DONE, Mode.COMPLETING),
    ((Mode.COMPLETING,), Cause.DONE, Mode.COMPLETE),
    (_AT_WORK, Cause.HOLD, Mode.HOLDING),
    ((Mode.HOLDING,), Cause.DONE, Mode.HELD),
    ((Mode.HELD,), Cause.UNHOLD, Mode.UNHOLDING),
    ((Mode.UNHOLDING,), Cause.DONE, Mode.EXECUTE),
    ((Mode.EXECUTE,), Cause.SUSPEND, Mode.SUSPENDING),
    ((Mode.SUSPENDING,), Cause.DONE, Mode.SUSPENDED),
    ((Mode.SUSPENDED,), Cause.UNSUSPEND, Mode.UNSUSPENDING),
    ((Mode.UNSUSPENDING,), Cause.DONE, Mode.EXECUTE),
    (_all_but(_STOPPED), Cause.STOP, Mode.STOPPING),
    ((Mode.STOPPING,), Cause.DONE, Mode.STOPPED),
    (_all_but(_ABORTED), Cause.ABORT, Mode.ABORTING),
    ((Mode.ABORTING,), Cause.DONE, Mode.ABORTED),
    ((Mode.ABORTED,), Cause.CLEAR, Mode.CLEARING),
    ((Mode.CLEARING,), Cause.DONE, Mode.STOPPED),
)

TRANSITIONS: Mapping[Mode, Mapping[Cause, Mode]] = {
    mode: {cause: after for before, cause, after in _ROWS if mode in before} for mode in Mode
}
"""Which state follows which, and why."""

VERBS: Mapping[Cause, str] = {
    Cause.RESET: 'reset',
    Cause.START: 'start',
    Cause.HOLD: 'pause',
    Cause.UNHOLD: 'resume',
    Cause.STOP: 'stop',
    Cause.ABORT: 'abort',
    Cause.CLEAR: 'clear',
}
"""What people call the commands; to suspend and unsuspend is the cell's own affair."""

HOLD_ANYWHERE = (Cause.HOLD, Cause.UNHOLD)
"""Commands about pauses, which stand in every state and act where the table says (7.3)."""


def refusal(mode: Mode, cause: Cause) -> str | None:
    """Say why a command cannot be carried out in a state, and what can; None: it can."""
    if cause in TRANSITIONS[mode] or cause in HOLD_ANYWHERE:
        return None
    fitting = ' or '.join(one.value for one in Mode if cause in TRANSITIONS[one])
    if len(fitting.split(' or ')) > 2:
        fitting = 'another state'
    possible = ', '.join(VERBS[one] for one in possible_in(mode))
    return f'the cell is {mode.value}; {VERBS[cause]} is for {fitting}; possible now: {possible}'


def possible_in(mode: Mode) -> tuple[Cause, ...]:
    """Return the commands that people may give in a state."""
    return tuple(cause for cause in VERBS if cause in (*TRANSITIONS[mode], *HOLD_ANYWHERE))
