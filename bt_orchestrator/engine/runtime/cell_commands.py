"""The effects of commands to the cell, or the reasons of refusals (semantics 7.2, 7.3)."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping

from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.engine.runtime.deciding import Decided, decides
from bt_orchestrator.engine.runtime.lifecycle import transition
from bt_orchestrator.engine.runtime.operators import released_with
from bt_orchestrator.model import effects
from bt_orchestrator.model import events as e
from bt_orchestrator.model.failures import ABORT
from bt_orchestrator.model.hold_words import hold_name
from bt_orchestrator.model.judging.belt_statement import corrections
from bt_orchestrator.model.limits import PAUSES
from bt_orchestrator.model.packml import (
    NOT_IN_MANUAL,
    VERBS,
    Cause,
    PackmlState,
    UnitMode,
    refusal,
)
from bt_orchestrator.model.requests import About, Asked, requests_about
from bt_orchestrator.model.state import CellState, Hold
from bt_orchestrator.model.stop_reason import PAUSED, StopReason, release_command
from bt_orchestrator.model.words import joined, sentence

IN_MANUAL = sentence('in_manual')

RESUME = VERBS[Cause.UNHOLD]
"""The ways in which a pause ends."""


@decides(*(request for request in requests_about(About.CELL) if request.cause is not None))
def _command(state: CellState, asked: Asked, _: float) -> Decided:
    """Command the cell, if its state allows it."""
    cause = asked.request.cause
    assert cause is not None, asked.request.name
    if state.unit_mode is UnitMode.MANUAL and cause in NOT_IN_MANUAL:
        name = asked.request.name
        raise CommandRefused(sentence('refused_because', request=name, words=IN_MANUAL))
    why = refusal(state.packml, cause)
    if why is not None and _is_told_late(state, asked):
        return sentence('told_late', verb=asked.request.word), ()
    if why is not None:
        raise CommandRefused(why)
    if cause in _MOVES:
        return _MOVES[cause], [transition(state.packml, cause, str(asked.by))]
    message, follows = _ACTS[cause](state, asked)
    return message, list(follows)


def _is_told_late(state: CellState, asked: Asked) -> bool:
    """Tell whether a command gives the reason of the same one before (semantics 7.10)."""
    return bool(asked.arguments.get('code')) and state.packml in _TELLS_LATE.get(
        asked.request.cause, ()
    )


_TELLS_LATE: Mapping[Cause | None, Collection[PackmlState]] = {
    Cause.STOP: (PackmlState.STOPPING, PackmlState.STOPPED),
    Cause.ABORT: (PackmlState.ABORTING, PackmlState.ABORTED),
}

# --- words and events of each command -----------------------------------------------------------

_MOVES: Mapping[Cause, str] = {
    Cause.RESET: sentence('gets_ready'),
    Cause.START: sentence('starts'),
    Cause.STOP: sentence('finishes'),
}
"""Commands that only change the state of the cell, with their answers."""

_Act = tuple[str, Iterator[e.Event]]


def _pause(state: CellState, asked: Asked) -> _Act:
    """Raise a hold for this pause; whether the cell becomes Held follows from the stop reason.

    :raises CommandRefused: the maximum number of pauses is in effect
    """
    standing = sum(hold.reason == PAUSED for hold in state.pauses)
    if standing >= PAUSES:
        raise CommandRefused(sentence('many_pauses', count=standing))
    hold = e.HoldRaised(
        hold=state.next_hold,
        reason=PAUSED,
        message=str(asked.by),
        answers=(RESUME,),
        owner=asked.sender.who or 'unknown',
    )
    return sentence('paused_until', hold=hold.hold), iter([hold])


def _resume(state: CellState, asked: Asked) -> _Act:
    """Release pauses; a reason of the plant is for the one that is named (7.10).

    :raises CommandRefused: there are none, others have requested them, or a reason is for none
    """
    if asked.arguments.get('code') and asked.arguments.get('hold') is None:
        raise CommandRefused(sentence('reason_of_one'))
    released = [hold.id for hold in _to_release(state, asked)]
    return _after_resume(state, released), (e.HoldReleased(hold=hold) for hold in released)


def _abort(state: CellState, asked: Asked) -> _Act:
    return effects.cancelled_words(len(state.running)), events_of_abort(state, str(asked.by))


def events_of_abort(state: CellState, words: str) -> Iterator[e.Event]:
    """Yield the cancel of every goal, and the state of the cell."""
    yield e.StopReasonChanged(stop_reason=StopReason.EMERGENCY.value, reason=words)
    yield transition(state.packml, Cause.ABORT, words)
    yield from effects.cancelled(state, state.running, ABORT)


def _clear(state: CellState, asked: Asked) -> _Act:
    return sentence('belt_confirmed'), _events_of_clear(state, asked)


def _events_of_clear(state: CellState, asked: Asked) -> Iterator[e.Event]:
    for gone in corrections(state, asked['belt']):
        yield gone
        yield from released_with(state, gone.item)
    yield e.StopReasonChanged(stop_reason='', reason=str(asked.by))
    yield transition(state.packml, Cause.CLEAR, str(asked.by))


_ACTS: Mapping[Cause, Callable[[CellState, Asked], _Act]] = {
    Cause.HOLD: _pause,
    Cause.UNHOLD: _resume,
    Cause.ABORT: _abort,
    Cause.CLEAR: _clear,
}


# --- owners of pauses -------------------------------------------------------------------------


def _to_release(state: CellState, asked: Asked) -> list[Hold]:
    """Return the pauses that the command releases.

    :raises CommandRefused: there are none, or others have requested them
    """
    if not state.pauses:
        waiting = _named(state.holds)
        kind = 'not_paused_waits' if waiting else 'not_paused'
        raise CommandRefused(sentence(kind, state=state.packml.value, named_holds=waiting))
    named = asked.arguments.get('hold')
    if named is not None:
        chosen = [hold for hold in state.pauses if hold.id == named]
    else:
        chosen = [hold for hold in state.pauses if _is_meant(hold, asked)]
    if chosen:
        return chosen
    there = joined(*map(_pause_in_words, state.pauses))
    if named is not None:
        raise CommandRefused(joined(sentence('no_pause', hold=named), there))
    if all(hold.must_be_named for hold in state.pauses):
        raise CommandRefused(joined(sentence('nothing_released'), there))
    raise CommandRefused(joined(sentence('no_pause_yours'), there, sentence('pause_of_others')))


def _is_meant(hold: Hold, asked: Asked) -> bool:
    """Tell whether a command that names no pause refers to this one."""
    if hold.must_be_named:
        return False
    everyones = asked.arguments.get('everyones', False)
    return everyones or hold.owner in ('', asked.sender.who or 'unknown')


def _after_resume(state: CellState, released: Collection[str]) -> str:
    still = [hold for hold in state.pauses if hold.id not in released]
    if still:
        return sentence('still_paused', words=joined(*map(_pause_in_words, still)))
    holds = [hold for hold in state.holds if hold not in released]
    if not holds:
        return sentence('cell_goes_on')
    return sentence('paused_no_more', named_holds=_named(holds))


def _named(holds: Iterable[str]) -> str:
    return ', '.join(sentence('hold', hold=hold) for hold in holds)


def _pause_in_words(hold: Hold) -> str:
    if not hold.must_be_named:
        return hold_name(hold)
    command = release_command(hold.id)
    return sentence('pause_by_number', held=hold_name(hold), command=command)
