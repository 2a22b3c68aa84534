"""The states of the cell and their transitions, after PackML (ISA-TR88.00.02; semantics 7.2).

One table. Code asks it, documentation prints it, and tests walk through it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from enum import Enum

from bt_orchestrator.model.words import sentence


class PackmlState(Enum):
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

        Suspended blocks nothing: it means that the line waits for its source or sink, and it ends
        when anything can start.
        """
        return self in _BEGIN

    @property
    def works(self) -> bool:
        """Tell whether cycles in progress continue (semantics 7.1: a hold lets them finish)."""
        return self in _WORK


_BEGIN = (
    PackmlState.EXECUTE,
    PackmlState.SUSPENDING,
    PackmlState.SUSPENDED,
    PackmlState.UNSUSPENDING,
)
_WORK = (
    *_BEGIN,
    PackmlState.HOLDING,
    PackmlState.HELD,
    PackmlState.UNHOLDING,
    PackmlState.STOPPING,
)

MEANINGS: Mapping[PackmlState, str] = {
    PackmlState.STOPPED: (
        'nothing runs, nothing starts; waits for `reset`, or for an order if no operator '
        'stopped it'
    ),
    PackmlState.RESETTING: 'gets ready to start',
    PackmlState.IDLE: 'ready; waits for `start`, or for an order if no operator stopped it',
    PackmlState.STARTING: 'begins to work',
    PackmlState.EXECUTE: 'works',
    PackmlState.COMPLETING: 'the last job has ended',
    PackmlState.COMPLETE: 'every job has ended; waits for `reset`, or for an order',
    PackmlState.HOLDING: 'something is held: what runs goes on to its end, no cycle begins',
    PackmlState.HELD: 'something is held, and nothing runs: waits for people',
    PackmlState.UNHOLDING: 'goes back to work',
    PackmlState.SUSPENDING: 'nothing can start because source or sink is not ready',
    PackmlState.SUSPENDED: 'waits for the source or the sink; goes on by itself',
    PackmlState.UNSUSPENDING: 'goes back to work',
    PackmlState.STOPPING: (
        'finishes the cycles in hand; at the end of the node: cancels every goal'
    ),
    PackmlState.ABORTING: 'every goal is being cancelled; their ends are awaited',
    PackmlState.ABORTED: 'nothing moves; waits for `clear`',
    PackmlState.CLEARING: 'takes over what the operator said of the belt',
}
"""The meaning of each state, for people."""


class UnitMode(Enum):
    """PackML unit mode: how the cell is used (semantics 7.11)."""

    PRODUCTION = 'production'
    MANUAL = 'manual'
    """The cell stands, and runs single goals for an engineer at a panel."""


class Cause(Enum):
    """The cause of a transition: a PackML command, or completion of a state."""

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
    """The acting state is complete (PackML: state complete)."""


_AT_WORK = (
    PackmlState.STARTING,
    PackmlState.EXECUTE,
    PackmlState.UNHOLDING,
    PackmlState.SUSPENDING,
    PackmlState.SUSPENDED,
    PackmlState.UNSUSPENDING,
)
_ABORTED = (PackmlState.ABORTING, PackmlState.ABORTED)
_STOPPED = (PackmlState.STOPPING, PackmlState.STOPPED, PackmlState.CLEARING, *_ABORTED)


def _all_but(states: Iterable[PackmlState]) -> tuple[PackmlState, ...]:
    return tuple(state for state in PackmlState if state not in states)


_ROWS: tuple[tuple[tuple[PackmlState, ...], Cause, PackmlState], ...] = (
    ((PackmlState.STOPPED, PackmlState.COMPLETE), Cause.RESET, PackmlState.RESETTING),
    ((PackmlState.RESETTING,), Cause.DONE, PackmlState.IDLE),
    ((PackmlState.IDLE,), Cause.START, PackmlState.STARTING),
    ((PackmlState.STARTING,), Cause.DONE, PackmlState.EXECUTE),
    ((PackmlState.EXECUTE,), Cause.DONE, PackmlState.COMPLETING),
    ((PackmlState.COMPLETING,), Cause.DONE, PackmlState.COMPLETE),
    (_AT_WORK, Cause.HOLD, PackmlState.HOLDING),
    ((PackmlState.HOLDING,), Cause.DONE, PackmlState.HELD),
    ((PackmlState.HELD,), Cause.UNHOLD, PackmlState.UNHOLDING),
    ((PackmlState.UNHOLDING,), Cause.DONE, PackmlState.EXECUTE),
    ((PackmlState.EXECUTE,), Cause.SUSPEND, PackmlState.SUSPENDING),
    ((PackmlState.SUSPENDING,), Cause.DONE, PackmlState.SUSPENDED),
    ((PackmlState.SUSPENDED,), Cause.UNSUSPEND, PackmlState.UNSUSPENDING),
    ((PackmlState.UNSUSPENDING,), Cause.DONE, PackmlState.EXECUTE),
    (_all_but(_STOPPED), Cause.STOP, PackmlState.STOPPING),
    ((PackmlState.STOPPING,), Cause.DONE, PackmlState.STOPPED),
    (_all_but(_ABORTED), Cause.ABORT, PackmlState.ABORTING),
    ((PackmlState.ABORTING,), Cause.DONE, PackmlState.ABORTED),
    ((PackmlState.ABORTED,), Cause.CLEAR, PackmlState.CLEARING),
    ((PackmlState.CLEARING,), Cause.DONE, PackmlState.STOPPED),
)

TRANSITIONS: Mapping[PackmlState, Mapping[Cause, PackmlState]] = {
    state: {cause: after for before, cause, after in _ROWS if state in before}
    for state in PackmlState
}
"""The state that follows each state, and the cause."""

VERBS: Mapping[Cause, str] = {
    Cause.RESET: 'reset',
    Cause.START: 'start',
    Cause.HOLD: 'pause',
    Cause.UNHOLD: 'resume',
    Cause.STOP: 'stop',
    Cause.ABORT: 'abort',
    Cause.CLEAR: 'clear',
}
"""The command words for people; the cell suspends and unsuspends by itself."""

HOLD_ANYWHERE = (Cause.HOLD, Cause.UNHOLD)
"""Commands for pauses, possible in every state; they take effect as the table says (7.3)."""


MANUAL_FROM = (PackmlState.STOPPED, PackmlState.IDLE)
"""States in which the cell stands in manual mode (semantics 7.11)."""

NOT_IN_MANUAL = (Cause.RESET, Cause.START)
"""Commands that would let it work."""


def refusal(state: PackmlState, cause: Cause) -> str | None:
    """Say why a command cannot be carried out in a state, and what can; None: it can."""
    if cause in TRANSITIONS[state] or cause in HOLD_ANYWHERE:
        return None
    fitting = [other.value for other in PackmlState if cause in TRANSITIONS[other]]
    return sentence(
        'not_in_state' if len(fitting) <= 2 else 'not_in_this_state',
        state=state.value,
        verb=VERBS[cause],
        states=' or '.join(fitting),
        verbs=', '.join(VERBS[other] for other in possible_in(state)),
    )


def possible_in(state: PackmlState) -> tuple[Cause, ...]:
    """Return the commands that people may give in a state."""
    return tuple(cause for cause in VERBS if cause in (*TRANSITIONS[state], *HOLD_ANYWHERE))
