"""Automatic changes of the cell and its jobs: job ends, stop reasons, PackML states.

Semantics 6.1 and 7.2. The stop reason is recorded first; the state of the cell follows from it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict
from typing import NamedTuple

from bt_orchestrator.base.deadlines import has_come
from bt_orchestrator.engine.runtime.ledger import Ledger
from bt_orchestrator.model import events as e
from bt_orchestrator.model.events import TaskKey
from bt_orchestrator.model.hold_words import hold_name
from bt_orchestrator.model.limits import ENDED_KEPT
from bt_orchestrator.model.line import is_complete
from bt_orchestrator.model.packml import TRANSITIONS, Cause, PackmlState
from bt_orchestrator.model.state import CellState, Phase
from bt_orchestrator.model.stop_reason import WORDS, StopReason
from bt_orchestrator.model.words import sentence

AUTOMATIC = 'an order arrived'


class Outlook(NamedTuple):
    """The facts of the last tick, beyond the state."""

    still: bool
    """No goal runs, and none can start before something changes."""
    unready: bool
    """A cycle in progress waits only for the readiness of a component."""
    starved: Starved | None
    """The line has waited for its source or sink for a while."""


def is_still(state: CellState, is_delayed: Callable[[e.TaskKey], bool], *, quiet: bool) -> bool:
    """Tell whether no goal runs and none can start.

    :param is_delayed: whether the next attempt of a task waits for its time
    :param quiet: the tree decided nothing in its last tick
    """
    return quiet and not state.running and not _will_retry(state, is_delayed)


LAST_OF_A_JOB = {
    e.CycleCompleted,
    e.ItemRemoved,
    e.PositionEnded,
    e.JobStopping,
    e.JobAborting,
}
"""Events that may end a job, besides those of its initialization tasks."""

OF_THE_LINE = {
    *(e.TaskStarted, e.TaskSucceeded, e.FlagRaised, e.FlagLowered),
    *(e.CycleStarted, e.TurnCompleted, e.CycleCompleted),
    *(e.BeatStarted, e.BeltIndexStarted, e.BeltIndexed),
    *(e.ItemPlaced, e.ItemMoved, e.ItemRemoved, e.ItemIdentified),
}
"""Events after which the state of the cell stays the same while a goal is in flight."""


def jobs_ended(state: CellState) -> Iterator[e.JobCompleted | e.JobAborted]:
    """Yield the end of every job that has nothing left to do."""
    for job in state.jobs.at_work():
        if is_complete(state, job):
            kind = e.JobAborted if job.aborting else e.JobCompleted
            yield kind(
                job=job.job.id,
                exit_status=job.exit_status,
                reason=job.end_reason,
                counts=asdict(job.progress),
            )


def clear_oldest(state: CellState) -> Iterator[e.JobCleared]:
    """Make room for one more ended job."""
    if len(state.ended) >= ENDED_KEPT:
        reason = f'the last {ENDED_KEPT} that ended are listed'
        yield e.JobCleared(job=next(iter(state.ended)), reason=reason)


# --- the stop reason --------------------------------------------------------------------------


def stop_reason_change(state: CellState, outlook: Outlook) -> e.StopReasonChanged | None:
    """Return the due stop reason, unless it is recorded already (semantics 7.2)."""
    due, words = _due_reason(state, outlook)
    if due is state.stop_reason and words == state.stop_message:
        return None
    return e.StopReasonChanged(stop_reason=due.value if due else '', reason=words)


def _due_reason(state: CellState, outlook: Outlook) -> tuple[StopReason | None, str]:
    if state.stop_reason is StopReason.EMERGENCY:
        return StopReason.EMERGENCY, state.stop_message  # until an operator clears the cell
    if state.holds:
        first = next(iter(state.holds.values()))
        return (StopReason.OPERATOR if first.owner else StopReason.OWN_FAULT), hold_name(first)
    if state.packml in _STANDING and _is_interrupted(state):
        return StopReason.OPERATOR, sentence('stopped')
    if outlook.starved is not None and state.packml.begins:
        return outlook.starved.reason, outlook.starved.words
    return None, ''


_STANDING = (
    PackmlState.STOPPING,
    PackmlState.STOPPED,
    PackmlState.CLEARING,
    PackmlState.RESETTING,
    PackmlState.IDLE,
)
"""States from an operator's stop to the next start."""


def _is_interrupted(state: CellState) -> bool:
    return bool(state.jobs.line)


# --- the state of the cell --------------------------------------------------------------------


def next_mode(
    state: CellState, outlook: Outlook, *, auto_start: bool
) -> e.CellStateChanged | None:
    """Return the transition that is due.

    :param auto_start: the cell resets and starts by itself when an order arrives, unless an
        operator has stopped it
    """
    due = _by_stop_reason(state) or _by_itself(state, outlook, auto_start=auto_start)
    if due is None:
        return None
    cause, reason = due
    return transition(state.packml, cause, reason)


def transition(mode: PackmlState, cause: Cause, reason: str) -> e.CellStateChanged:
    """Return the event of a transition in the table."""
    after = TRANSITIONS[mode][cause]
    return e.CellStateChanged(
        state=after.value, previous=mode.value, cause=cause.value, reason=reason
    )


class _Standstill(NamedTuple):
    """A state in which the line stands until its cause is over."""

    stands_for: Cause
    ended_by: Cause


_LEFT_BY = {
    PackmlState.HELD: _Standstill(Cause.HOLD, Cause.UNHOLD),
    PackmlState.SUSPENDED: _Standstill(Cause.SUSPEND, Cause.UNSUSPEND),
}


def _by_stop_reason(state: CellState) -> tuple[Cause, str] | None:
    wanted = _wanted(state)
    if wanted is not None and wanted in TRANSITIONS[state.packml]:
        return wanted, state.stop_message
    if state.packml not in _LEFT_BY or _LEFT_BY[state.packml].stands_for is wanted:
        return None
    return _LEFT_BY[state.packml].ended_by, 'what stopped the line is over'


def _wanted(state: CellState) -> Cause | None:
    return WORDS[state.stop_reason].cell if state.stop_reason is not None else None


def _by_itself(
    state: CellState, outlook: Outlook, *, auto_start: bool
) -> tuple[Cause, str] | None:
    cause = _AUTOMATIC.get(state.packml)
    if cause is not None:
        may = auto_start and state.wish is None and not state.barred
        return (cause, AUTOMATIC) if may and state.has_work else None
    done = _why_done(state, outlook)
    return (Cause.DONE, done) if done is not None else None


_AUTOMATIC = {
    PackmlState.STOPPED: Cause.RESET,
    PackmlState.COMPLETE: Cause.RESET,
    PackmlState.IDLE: Cause.START,
}


def _why_done(state: CellState, outlook: Outlook) -> str | None:
    """Say why an acting state is complete; None: it is not."""
    mode, wanted = state.packml, _wanted(state)
    if Cause.DONE not in TRANSITIONS[mode]:
        return None
    if mode is PackmlState.EXECUTE:
        # A cell that was started before an order came waits for one. One that is to stop when its
        # line is empty stops instead.
        is_done = state.had_work and not state.has_work and state.stop_after is None
        return 'every job ended' if is_done else None
    if mode is PackmlState.ABORTING:
        return 'every goal ended' if outlook.still else None
    if mode is PackmlState.STOPPING:
        return _why_stopped(state, outlook)
    if mode is PackmlState.HOLDING and wanted is Cause.HOLD:
        return 'nothing runs and nothing can start' if outlook.still else None
    return ''


def _why_stopped(state: CellState, outlook: Outlook) -> str | None:
    if state.shutting_down:
        return None if state.running else 'every goal ended'
    # A component that is busy for another moment must not leave a cycle unfinished.
    finished = outlook.still and not outlook.unready
    return 'the cycles in hand are finished' if finished else None


def _will_retry(state: CellState, is_delayed: Callable[[e.TaskKey], bool]) -> bool:
    return any(
        task.phase is Phase.RETRYING and is_delayed(key) for key, task in state.tasks.items()
    )


# Whether the line waits only for its source or its sink (semantics 7.2).

SUSPEND_AFTER_S = 1.0
"""How long the line has to wait before it counts: most components report busy for a moment after a
task, which is not starvation."""


class Starved(NamedTuple):
    """The end of the line that is waited for."""

    reason: StopReason
    words: str


class Starvation:
    """Measures how long the line waits for its source or sink."""

    def __init__(self, ledger: Ledger) -> None:
        self._ledger = ledger
        self._waited_for: Starved | None = None
        self._since = 0.0

    def look(self, unready: Sequence[TaskKey]) -> Starved | None:
        """Say for what the line has been waiting long enough; None: it has not.

        :param unready: tasks that wait for their component while nothing else can go on
        """
        now = self._ledger.steady
        starvation = find_starvation(self._ledger.state, unready) if unready else None
        if starvation != self._waited_for:
            self._waited_for, self._since = starvation, now
        if starvation is None:
            return None
        due = self._since + SUSPEND_AFTER_S
        if has_come(due, now):
            return starvation
        self._ledger.wake_at(due)
        return None


def find_starvation(state: CellState, unready: Iterable[TaskKey]) -> Starved | None:
    """Return the end of the line that is waited for; of both, the sink (downstream first, 4.4)."""
    ends = [end for end in (_at_an_end(state, key) for key in unready) if end is not None]
    blocked = [end for end in ends if end.reason is StopReason.BLOCKED]
    return next(iter([*blocked, *ends]), None)


def _at_an_end(state: CellState, key: TaskKey) -> Starved | None:
    """Return the end of the line where a task waits; None: between, or in initialization."""
    task = state.task(key)
    if task is None or key.job is None or key.section is None:
        return None
    script = state.script(key.job)
    at_source, at_sink = (key.section == end for end in (script.source, script.sink))
    if at_source and at_sink:
        at_source = state.slot(key.section) is None  # nothing is placed yet
    if not at_source and not at_sink:
        return None
    reason = StopReason.STARVED if at_source else StopReason.BLOCKED
    if state.readings[task.component].ready:
        return None  # it waits because of a fault, not for material
    topic = state.cell.components[task.component].state
    return Starved(reason, sentence('starved', task=key, topic=topic))
