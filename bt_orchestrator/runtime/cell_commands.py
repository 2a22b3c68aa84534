"""What the commands to the cell do, or why they are refused (semantics 7.2, 7.3)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from bt_orchestrator.errors import CommandRefused
from bt_orchestrator.model import effects
from bt_orchestrator.model import events as e
from bt_orchestrator.model.belt_statement import corrections
from bt_orchestrator.model.cell_commands import (
    Abort,
    CellCommand,
    Clear,
    Pause,
    Reset,
    Resume,
    Start,
    Stop,
)
from bt_orchestrator.model.failures import ABORT
from bt_orchestrator.model.hold_words import hold_name
from bt_orchestrator.model.limits import PAUSES
from bt_orchestrator.model.packml import VERBS, Cause, refusal
from bt_orchestrator.model.pauses import PAUSED, release_command
from bt_orchestrator.model.state import CellState, Hold
from bt_orchestrator.model.stop_reason import StopReason
from bt_orchestrator.runtime.command_record import decided
from bt_orchestrator.runtime.ledger import Ledger
from bt_orchestrator.runtime.lifecycle import transition
from bt_orchestrator.runtime.operators import released_with

RESUME = VERBS[Cause.UNHOLD]
"""What ends a pause."""


def carry_out(command: CellCommand, ledger: Ledger) -> str:
    """Carry out a command and return the answer's words.

    :raises CommandRefused: it is not possible now; nothing was recorded
    """
    state = ledger.state
    why = refusal(state.packml, command.cause)
    if why is not None:
        raise CommandRefused(why)
    follows = list(_FOLLOWS[type(command)](state, command))
    ledger.record([*decided(command), *follows])
    return _ANSWERS[type(command)](state)


# --- the events of each command; these functions change nothing -------------------------------


def _reset(state: CellState, command: Reset) -> Iterator[e.Event]:
    yield transition(state.packml, command.cause, str(command.by))


def _start(state: CellState, command: Start) -> Iterator[e.Event]:
    yield transition(state.packml, command.cause, str(command.by))


def _stop(state: CellState, command: Stop) -> Iterator[e.Event]:
    yield transition(state.packml, command.cause, str(command.by))


def _pause(state: CellState, command: Pause) -> Iterator[e.Event]:
    """Raise a hold for this pause; whether the cell becomes Held follows from the stop reason.

    :raises CommandRefused: the maximum number of pauses is in effect
    """
    standing = sum(hold.reason == PAUSED for hold in state.pauses)
    if standing >= PAUSES:
        raise CommandRefused(
            f'{standing} pauses stand already, and more are not kept; each of them keeps the '
            'cell from starting anything until it is released with resume'
        )
    yield e.HoldRaised(
        hold=state.next_hold,
        reason=PAUSED,
        message=str(command.by),
        answers=(RESUME,),
        owner=command.by.who or 'unknown',
    )


def _resume(state: CellState, command: Resume) -> Iterator[e.Event]:
    for hold in _to_release(state, command):
        yield e.HoldReleased(hold=hold.id)


def _abort(state: CellState, command: Abort) -> Iterator[e.Event]:
    emergency, words = StopReason.EMERGENCY, str(command.by)
    yield e.StopReasonChanged(stop_reason=emergency.value, reason=words)
    yield transition(state.packml, command.cause, words)
    yield from effects.cancelled(state, state.running, ABORT)


def _clear(state: CellState, command: Clear) -> Iterator[e.Event]:
    for gone in corrections(state, command.belt):
        yield gone
        yield from released_with(state, gone.item)
    yield e.StopReasonChanged(stop_reason='', reason=str(command.by))
    yield transition(state.packml, command.cause, str(command.by))


_FOLLOWS: Mapping[type[CellCommand], Callable[[CellState, Any], Iterator[e.Event]]] = {
    Reset: _reset,
    Start: _start,
    Stop: _stop,
    Pause: _pause,
    Resume: _resume,
    Abort: _abort,
    Clear: _clear,
}


# --- owners of pauses -------------------------------------------------------------------------


def _to_release(state: CellState, command: Resume) -> list[Hold]:
    """Return the pauses that the command releases.

    :raises CommandRefused: there are none, or others have requested them
    """
    if not state.pauses:
        raise CommandRefused(f'the cell is not paused; {_instead(state)}')
    if command.hold is not None:
        chosen = [hold for hold in state.pauses if hold.id == command.hold]
    else:
        chosen = [hold for hold in state.pauses if _is_meant(hold, command)]
    if chosen:
        return chosen
    there = '; '.join(map(_pause_in_words, state.pauses))
    if command.hold is not None:
        raise CommandRefused(f'there is no pause {command.hold}; {there}')
    if all(hold.must_be_named for hold in state.pauses):
        raise CommandRefused(f'nothing was released; {there}')
    raise CommandRefused(
        f'none of the pauses is yours; {there}; the person who paused resumes, or name the hold '
        'to release it for that person'
    )


def _is_meant(hold: Hold, command: Resume) -> bool:
    """Tell whether a command that names no pause refers to this one."""
    if hold.must_be_named:
        return False
    return command.everyones or hold.owner in ('', command.by.who or 'unknown')


def _instead(state: CellState) -> str:
    waiting = ', '.join(f'hold {hold}' for hold in state.holds)
    return f'it waits for answers to {waiting}' if waiting else f'it is {state.packml.value}'


def _pause_in_words(hold: Hold) -> str:
    if not hold.must_be_named:
        return hold_name(hold)
    return f'{hold_name(hold)}, which only its number releases: {release_command(hold.id)}'


# --- answers ----------------------------------------------------------------------------------


def _after_resume(state: CellState) -> str:
    if state.pauses:
        return 'still paused: ' + '; '.join(map(_pause_in_words, state.pauses))
    if state.holds:
        return f'no longer paused; {_instead(state)}'
    return 'the cell goes on'


def _after_abort(state: CellState) -> str:
    number = len(state.running)
    return f'{number} goal{"s are" if number != 1 else " is"} being cancelled'


_ANSWERS: Mapping[type[CellCommand], Callable[[CellState], str]] = {
    Reset: lambda _: 'the cell gets ready',
    Start: lambda _: 'the cell starts',
    Stop: lambda _: 'the cell finishes the cycles in hand and stops',
    Pause: lambda state: (
        f'the cell starts nothing more until hold {list(state.holds)[-1]} is over'
    ),
    Resume: _after_resume,
    Abort: _after_abort,
    Clear: lambda _: 'the belt is confirmed; the cell stops, reset and start let it go on',
}
