"""Why nothing moves: one root cause, told where it has lasted for a second (semantics 7.4).

It is read outside the tick: the latched status is renewed every second, so no timer is needed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Protocol

from bt_orchestrator.engine.tree.compile import CellTree
from bt_orchestrator.model.frozen import changed
from bt_orchestrator.model.hold_words import hold_wait_words
from bt_orchestrator.model.jobs.needs import needs_words
from bt_orchestrator.model.limits import QUEUE_SHOWN
from bt_orchestrator.model.line import barred_because
from bt_orchestrator.model.packml import PackmlState, UnitMode
from bt_orchestrator.model.state import CellState, Hold, JobState
from bt_orchestrator.model.stop_reason import StopReason, way_to_work
from bt_orchestrator.model.wait import GRAVE, PartWait, StandCause, Stands, WaitKind
from bt_orchestrator.model.words import joined, sentence
from bt_orchestrator.ports import Goal, Servers


class Goals(Protocol):
    """The goals in flight."""

    def goal(self, goal_id: str) -> Goal | None:
        """Return a goal; None: it is not known."""


class Engine(Protocol):
    """One cell, its tree and its robots, as `Orchestrator` has them."""

    @property
    def state(self) -> CellState:
        """The state."""

    @property
    def tree(self) -> CellTree:
        """Its behaviours, ticked."""

    @property
    def gateway(self) -> Servers:
        """Its action servers as seen."""

    @property
    def flights(self) -> Goals:
        """Its goals in flight."""

    @property
    def broken(self) -> str | None:
        """Why the engine has stopped; None: it works."""

    @property
    def disk_wait(self) -> str:
        """The write that the disk has not finished; empty: none."""


TOLD_AFTER_S = 1.0
"""How long nothing moves before a standstill is reported: between two goals nothing moves for a
moment."""

Waits = Callable[[], Sequence[PartWait]]


class Standstill:
    """Watches whether the cell stands, from one look to the next."""

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._seen: Stands | None = None
        self._clock_set_s = 0.0
        """By how much the clock had been set then."""
        self.told: Stands | None = None
        """The result of the last look; None: something moves, or did a moment ago."""

    def look(self, now_s: float, waits: Waits, rest_s: float | None = None) -> Stands | None:
        """Say why the cell stands.

        :param rest_s: of a past moment: when it came to rest; None: with the last event
        :param waits: returns who waits for what; called only where no goal runs
        """
        engine, before, report = self._engine, self._seen, self.told
        set_s, self._clock_set_s = self._clock_set_s, engine.state.clock_set_s
        stands = None
        if not engine.state.running and (engine.broken or not engine.tree.is_due):
            stands = _cause(engine.state, engine.broken, waits)
        if stands is not None:
            if before is not None and _same(before, stands):
                since = before.since + self._clock_set_s - set_s
            else:
                since, report = engine.state.time if rest_s is None else rest_s, None
            stands = changed(stands, since=since)
        self._seen = stands
        # Once told it stays told: the clock may have been set, and that not be on record yet.
        is_told = stands and (report is not None or now_s - stands.since >= TOLD_AFTER_S)
        self.told = stands if is_told else None
        return self.told


def _same(stands: Stands, other: Stands) -> bool:
    return (stands.cause, stands.name) == (other.cause, other.name)


def _stands(
    cause: StandCause,
    reason: str,
    name: str = '',
    sections: tuple[int, ...] = (),
    components: tuple[str, ...] = (),
) -> Stands:
    return Stands(0.0, cause, reason, name, sections, components)


def _cause(state: CellState, broken: str | None, waits: Waits) -> Stands:
    """Return the root cause: the journal, an abort, holds, commands; then waits and the queue."""
    if broken:
        return _stands(StandCause.JOURNAL, broken)
    if state.packml in _ABORTED or state.barred:
        return _for_a_command(state)
    if state.unit_mode is UnitMode.MANUAL:
        return _stands(StandCause.COMMAND, _MANUAL, UnitMode.MANUAL.value)
    if state.holds:
        return _held(next(iter(state.holds.values())))
    if state.packml in _AT_REST:
        may_work = state.stopped_by is None and not state.has_work
        return _idle(state) if may_work else _for_a_command(state)
    return _waiting(state, waits()) if state.has_work else _idle(state)


_ABORTED = (PackmlState.ABORTING, PackmlState.ABORTED, PackmlState.CLEARING)
_AT_REST = (
    PackmlState.STOPPED,
    PackmlState.RESETTING,
    PackmlState.IDLE,
    PackmlState.COMPLETE,
)


_MANUAL = 'the cell is in manual mode; it waits for production'


def _for_a_command(state: CellState) -> Stands:
    if state.barred:
        return _stands(StandCause.COMMAND, barred_because(state))
    way = way_to_work(state.packml)
    who = f' ({state.stopped_by})' if state.stopped_by else ''
    reason = f'the cell is {state.packml.value}{who}; it waits for {way}'
    return _stands(StandCause.COMMAND, reason, state.packml.value)


def _held(hold: Hold) -> Stands:
    cause = StandCause.PAUSE if hold.owner else StandCause.HOLD
    sections = (hold.section,) if hold.section else ()
    components = (hold.component,) if hold.component else ()
    return _stands(cause, hold_wait_words([hold]), hold.id, sections, components)


# --- a cell that works --------------------------------------------------------------------------


def _waiting(state: CellState, waits: Sequence[PartWait]) -> Stands:
    """Return the gravest of the waits: all others end when it does, or name another then."""
    if not waits:
        return _stands(StandCause.OTHER, 'nothing says what it waits for')
    first = min(waits, key=lambda part_wait: _RANK.get(part_wait.wait.kind, len(_RANK)))
    wait = first.wait
    cause = _CAUSES.get(wait.kind, StandCause.OTHER)
    components: tuple[str, ...] = ()
    if wait.kind in (WaitKind.READINESS, WaitKind.OUT_OF_SERVICE):
        components = (wait.name,)
    if wait.kind is WaitKind.READINESS:
        cause = _unready(state, wait.name)
    same = [
        part_wait
        for part_wait in waits
        if (part_wait.wait.kind, part_wait.wait.name) == (wait.kind, wait.name)
    ]
    sections = tuple(part_wait.section for part_wait in same if part_wait.section is not None)
    return _stands(cause, f'{first.part}: {wait.reason}', wait.name, sections, components)


_CAUSES = {
    WaitKind.OUT_OF_SERVICE: StandCause.OUT_OF_SERVICE,
    WaitKind.READINESS: StandCause.NOT_READY,
    WaitKind.HOLD: StandCause.HOLD,
    WaitKind.PAUSE: StandCause.PAUSE,
    WaitKind.RETRY_DELAY: StandCause.RETRY_DELAY,
    WaitKind.CELL_STATE: StandCause.COMMAND,
}
"""The root cause behind a wait that ends outside of the line."""

_RANK = {kind: rank for rank, kind in enumerate(GRAVE)}

_ENDS = {StopReason.STARVED: StandCause.STARVED, StopReason.BLOCKED: StandCause.BLOCKED}


def _unready(state: CellState, component: str) -> StandCause:
    """Return why a task waits for a component that is in service."""
    if state.readings[component].ready:
        return StandCause.CONTESTED
    reason = state.stop_reason
    return _ENDS.get(reason, StandCause.NOT_READY) if reason else StandCause.NOT_READY


# --- a cell without work ------------------------------------------------------------------------


def _idle(state: CellState) -> Stands:
    """Return what the first job of the queue waits for, or that there is none."""
    job = next(iter(state.jobs.first(QUEUE_SHOWN)), None)
    causes = list(obstacles(job)) if job is not None else []
    if job is None or not causes:
        return _stands(StandCause.ORDER, 'there is no job; the cell waits for an order')
    words = joined(*(text for _, text in causes), _more_words(state.jobs.waiting - 1))
    return _stands(causes[0][0], words, job.job.id, components=job.unavailable)


def _more_words(jobs: int) -> str:
    kind = 'one_more_waits' if jobs == 1 else 'more_wait'
    return sentence(kind, count=jobs) if jobs else ''


def obstacles(job: JobState) -> Iterator[tuple[StandCause, str]]:
    """Yield what keeps a queued job from starting, and the sentence that says so."""
    name = job.job.id
    if job.held:
        yield StandCause.JOB_HELD, sentence('job_held', job=name)
    if job.awaits_release:
        yield StandCause.RELEASE, sentence('job_unreleased', job=name)
    if job.unavailable:
        yield StandCause.OUT_OF_SERVICE, needs_words(name, job.unavailable)
    if job.awaits_start:
        yield StandCause.JOB_START, sentence('job_awaits_start', job=name)
