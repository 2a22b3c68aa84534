"""Commands to the queue and its jobs: events, or a refusal (semantics 6.6, 7.2)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from itertools import chain
from operator import add

from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.engine.runtime import listed_jobs, orders
from bt_orchestrator.engine.runtime.deciding import Decided, decided, decides, is_elsewhere
from bt_orchestrator.engine.runtime.lifecycle import transition
from bt_orchestrator.model import effects
from bt_orchestrator.model import events as e
from bt_orchestrator.model.by import named
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.jobs import job_control
from bt_orchestrator.model.jobs.isa95 import job_word
from bt_orchestrator.model.jobs.job_commands import AddJobs, RequeueJob, UpdateJob
from bt_orchestrator.model.jobs.job_control import lacks_words
from bt_orchestrator.model.jobs.job_folds import terms_of
from bt_orchestrator.model.jobs.needs import awaited_when_stopped, items_wait_words
from bt_orchestrator.model.limits import listed
from bt_orchestrator.model.packml import Cause, PackmlState
from bt_orchestrator.model.requests import (
    ADD,
    ARRANGE,
    MOVE,
    NEXT,
    REQUEUE,
    STOP_AFTERS,
    UPDATE,
    About,
    Asked,
    refusal,
    requests_about,
)
from bt_orchestrator.model.state import CellState, JobState
from bt_orchestrator.model.state.proposed import refused_order
from bt_orchestrator.model.stop_reason import AFTER, NEVER, STOP_AFTER, way_to_work
from bt_orchestrator.model.words import joined, sentence

Events = Iterator[e.Event]


# --- orders ---------------------------------------------------------------------------------


@decides(ADD)
def _add(state: CellState, command: AddJobs, now: float) -> Decided:
    if command.position is not None:
        _check_position(command.position, state.jobs.waiting + 1)
    waits = is_elsewhere(state, command.by)
    each = orders.queue(
        state,
        command.jobs,
        now,
        position=command.position,
        held=command.held or waits,
        sharing=command.sharing,
    )
    records = [list(decided(ADD.word, command.by, job=name)) for name in command.names]
    events = [*chain.from_iterable(map(add, records, each))]
    lines = [_how(event) for event in events if isinstance(event, e.JobQueued)]
    local = [AT_PANEL] if waits else []
    return '\n'.join([*lines, *local, *standing(state)]), events


AT_PANEL = sentence('panel_releases')


def _how(queued: e.JobQueued) -> str:
    kind = 'job_queued_held' if queued.held else 'job_queued'
    start = terms_of(queued).start_words
    early = sentence('awaits_start', moment=start) if queued.awaits_start else ''
    return joined(sentence(kind, job=queued.job), early, *_lacked(queued))


def _lacked(order: e.JobQueued | e.JobUpdated) -> Iterator[str]:
    """Say what an order lacks."""
    return lacks_words(order.digest if order.awaits_release else '', order.unavailable)


@decides(UPDATE)
def _update(state: CellState, command: UpdateJob, now: float) -> Decided:
    new, live = command.job, state.jobs.get(command.job.id)
    changes = live is not None and live.digest != digest(new.script)
    why_not = refusal(UPDATE, command.by, ['script']) if changes else None
    if why_not is not None:
        raise CommandRefused(why_not)
    allowed(state, job_control.UPDATE, new.id)
    changed = orders.change(
        state, new, now, command.sharing, command.anew, keeps_script=command.keeps_script
    )
    (updated,) = (event for event in changed if isinstance(event, e.JobUpdated))
    return '\n'.join([sentence('job_updated', job=new.id), *_lacked(updated)]), changed


@decides(REQUEUE)
def _requeue(state: CellState, command: RequeueJob, _: float) -> Decided:
    """Stop a job and queue its rest, both or neither: whatever is wrong is found before."""
    job = allowed(state, job_control.REQUEUE, command.job)
    rest = replace(command.rest, quantity=job.cycles_left)
    events = orders.queue_rest(state, rest, command.job, command.anew, command.sharing)
    (queued,) = (event for event in events if isinstance(event, e.JobQueued))
    lines = [sentence('job_runs_out', job=command.job), _how_rest(queued)]
    waits_for = awaited_when_stopped(state, job)
    if waits_for:
        lines.append(items_wait_words(command.job, waits_for))
    stopped = _stop(state, job, command.by.deciding(job_control.REQUEUE.verb))
    return '\n'.join([*lines, *standing(state)]), [*stopped, *events]


def _how_rest(queued: e.JobQueued) -> str:
    number, anew = '_1' if queued.quantity == 1 else '', '_anew' if queued.anew else ''
    values = {'job': queued.job, 'count': queued.quantity}
    words = queued.anew.words if queued.anew else ''
    return joined(sentence(f'rest_queued{number}{anew}', **values, anew=words), *_lacked(queued))


def standing(state: CellState) -> Iterator[str]:
    """Say so if the queued jobs wait for an operator (semantics 7.2)."""
    wish = state.wish
    if wish is not None:
        soon = '_soon' if state.stopped_by is None else ''
        yield sentence(
            f'awaits_way{soon}{"_why" if wish.reason else ""}',
            way=way_to_work(state.packml),
            who=named(wish.who, wish.known),
            verb=wish.command.replace('_', ' '),
            words=wish.reason,
        )


# --- places ---------------------------------------------------------------------------------


@decides(MOVE)
def _move(state: CellState, asked: Asked, _: float) -> Decided:
    name, position = asked['job'], asked['position']
    _check_queued(state, name)
    _check_position(position, state.jobs.waiting)
    moved = e.JobMoved(job=name, position=position)
    return sentence('job_placed', job=name, position=position), [moved]


@decides(NEXT)
def _run_next(state: CellState, asked: Asked, _: float) -> Decided:
    name = asked['job']
    job = _check_queued(state, name)
    events: list[e.Event] = [e.JobMoved(job=name, position=1)]
    if job.held:
        events.append(e.JobReleased(job=name))
    if job.awaits_start:
        events.append(e.JobMayStart(job=name))
    lines = [sentence('job_next', job=name), *_lacks(job), *standing(state)]
    return '\n'.join(lines), events


@decides(ARRANGE)
def _arrange(state: CellState, asked: Asked, _: float) -> Decided:
    wanted = tuple(asked['jobs'])
    refused = refused_order(state.jobs, wanted, asked['queue_digest'])
    if refused is not None:
        raise CommandRefused(refused)
    message = sentence('arranged', jobs=listed(wanted, 'nothing'))
    return message, [e.QueueArranged(jobs=wanted)]


def _lacks(job: JobState) -> Iterator[str]:
    return lacks_words(job.unreleased, job.unavailable)


# --- methods of a job -----------------------------------------------------------------------


def _release(_: CellState, job: JobState, __: str) -> Events:
    """Take the hold away; of a job that is not held, the wait for its start (semantics 6.7)."""
    kind = e.JobReleased if job.held else e.JobMayStart
    yield kind(job=job.job.id)


def _after_release(state: CellState, job: JobState) -> Iterator[str]:
    """Say what a job that was held until now still waits for."""
    if job.held and job.awaits_start:
        yield sentence('awaits_start_released', moment=job.job.terms.start_words)
    yield from _lacks(job)
    yield from standing(state)


def _only(event: Callable[..., e.Event]) -> Callable[[CellState, JobState, str], Events]:
    """Return a decider whose effect is one event."""
    return lambda _, job, __: iter([event(job=job.job.id)])


def _resume(_: CellState, job: JobState, __: str, *, another: bool = False) -> Events:
    if not job.paused:
        raise CommandRefused(sentence('job_not_paused', job=job.job.id))
    yield e.JobResumed(job=job.job.id, item=job.piece or None, another=another)


def _stop(_: CellState, job: JobState, reason: str) -> Events:
    yield e.JobStopping(job=job.job.id, reason=reason, item=job.piece or None)


def _abort(state: CellState, job: JobState, reason: str) -> Events:
    yield from effects.of_abort(state, job, reason)


_Control = tuple[job_control.Method, str, Callable[[CellState, JobState, str], Events]]

CONTROLS: Mapping[str, _Control] = {
    control[0].verb: control
    for control in (
        (job_control.REVOKE_START, 'job_is_held', _only(e.JobHeld)),
        (job_control.START, 'job_released', _release),
        (job_control.PAUSE, 'job_begins_none', _only(e.JobPaused)),
        (job_control.RESUME, 'job_goes_on', _resume),
        (job_control.ANOTHER, 'job_another_piece', partial(_resume, another=True)),
        (job_control.STOP, 'job_runs_out', _stop),
        (job_control.ABORT, 'job_aborting', _abort),
        (job_control.CANCEL, 'job_out', _only(e.JobRemoved)),
        (job_control.CLEAR, 'job_unlisted', _only(e.JobCleared)),
    )
}
"""By the command's word: the method, the kind of the answer, and the function that does it."""


@decides(*(request for request in requests_about(About.JOB) if request.word in CONTROLS))
def _control(state: CellState, asked: Asked, _: float) -> Decided:
    word, name = asked.request.word, asked['job']
    method, answer, act = CONTROLS[word]
    job = allowed(state, method, name)
    who = state.cell.first_piece
    why_not = job_control.not_approving(name, job.piece, asked.sender.role, who)
    if why_not is not None and method is job_control.RESUME:
        raise CommandRefused(why_not)
    events = list(act(state, job, asked.sender.deciding(word)))
    more = _after_release(state, job) if method is job_control.START else ()
    return '\n'.join([sentence(answer, job=name), *more]), events


# --- the line runs empty --------------------------------------------------------------------


@decides(STOP_AFTERS[NEVER])
def _go_on(state: CellState, _: Asked, __: float) -> Decided:
    if state.stop_after is None:
        raise CommandRefused(sentence('no_stop_wished'))
    return sentence('line_goes_on'), [e.QueueStopCancelled()]


@decides(*(STOP_AFTERS[after] for after in AFTER))
def _stop_after(state: CellState, asked: Asked, _: float) -> Decided:
    if not state.on_the_line:
        raise CommandRefused(sentence('none_started'))
    after = asked.request.word.removeprefix(STOP_AFTER)
    return sentence(f'stop_after_{after}'), [e.QueueStopRequested(after=after)]


_STANDS = (*(PackmlState.STOPPED, PackmlState.ABORTED), *(PackmlState.IDLE, PackmlState.COMPLETE))
"""States in which the cell has stopped already when its line is empty."""


def stop_when_empty(state: CellState) -> list[e.Event]:
    """Stop a cell that is still, once its line has run empty on request.

    A cell that stands makes no transition, but the request ends: else it would stop the cell
    after the next start.
    """
    if state.stop_after is None or not _is_empty(state):
        return []
    reached = e.QueueStopReached(after=state.stop_after)
    if state.packml is PackmlState.EXECUTE:
        reason = f'stop after the current {state.stop_after}'
        return [reached, transition(state.packml, Cause.STOP, reason)]
    return [reached] if state.packml in _STANDS else []


def _is_empty(state: CellState) -> bool:
    if any(hold.job is not None for hold in state.holds.values()):
        return False
    if state.stop_after == 'job':
        return not state.on_the_line
    return all(item.gone for item in state.items.values())


# --- refusals -------------------------------------------------------------------------------


def allowed(state: CellState, method: job_control.Method, name: str) -> JobState:
    """Return a job whose state allows a method now.

    :raises CommandRefused: there is no such job, or its state does not allow it
    """
    job = listed_jobs.find(state, name)
    facts = job_control.JobFacts(
        job_word(state, job),
        job.ending if job.ended_at is None else '',
        awaits_start=job.awaits_start,
        unreleased=job.unreleased,
        unavailable=job.unavailable,
        is_held=job.held,
        is_by_recipe=job.job.recipe is not None,
        left=job.cycles_left,
        piece=job.piece,
        piece_left=job.piece_left,
    )
    refused = job_control.refusal(method, name, facts)
    if refused is not None:
        raise CommandRefused(refused)
    return job


def _check_queued(state: CellState, name: str) -> JobState:
    job = state.jobs.get(name)
    if job is None or job.started:
        queue = listed(state.jobs.queued_names, 'nothing')
        kind = 'has_started' if job else 'not_queued'
        raise CommandRefused(sentence(kind, job=name, jobs=queue))
    return job


def _check_position(position: int, last: int) -> None:
    if not 1 <= position <= last:
        raise CommandRefused(sentence('place', last=last, position=position))
