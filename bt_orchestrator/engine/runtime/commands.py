"""The effect of each command: events, or a refusal with the reason."""

from __future__ import annotations

from itertools import chain

from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.engine.runtime import cell_commands, job_queue, operators
from bt_orchestrator.engine.runtime.deciding import (
    DECIDERS,
    Decided,
    decided,
    decides,
    not_allowed,
    not_from_there,
    signature,
)
from bt_orchestrator.engine.runtime.ledger import Ledger
from bt_orchestrator.engine.runtime.lifecycle import transition
from bt_orchestrator.engine.runtime.permits import manual, service
from bt_orchestrator.engine.runtime.permits.surroundings import refuse_unsafe
from bt_orchestrator.model import effects
from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.commands import Command, FoundTwin, RefusedRequest, Shutdown
from bt_orchestrator.model.failures import ABORT, SHUTDOWN
from bt_orchestrator.model.jobs.needs import is_released
from bt_orchestrator.model.limits import TWINS, listed
from bt_orchestrator.model.packml import TRANSITIONS, Cause
from bt_orchestrator.model.requests import CODE, RELEASE_SCRIPT, Asked
from bt_orchestrator.model.state import CellState
from bt_orchestrator.model.stop_reason import TWIN
from bt_orchestrator.model.words import sentence


@decides(RELEASE_SCRIPT)
def _release(state: CellState, asked: Asked, _: float) -> Decided:
    script, here, meant = asked['script'], digest(state.cell), asked.arguments.get('cell_digest')
    if meant and meant != here:
        raise CommandRefused(sentence('other_cell', script=script, meant=meant, digest=here))
    if is_released(state, script):
        raise CommandRefused(sentence('released_already', script=script))
    reason = '' if asked.by is None else str(asked.by)
    released = e.ScriptReleased(digest=script, cell_digest=here, reason=reason)
    return _said(script, state), [released]


def _said(script: str, state: CellState) -> str:
    waited = [job.job.id for job in state.queue if job.unreleased == script]
    kind = 'script_released_for' if waited else 'script_released'
    return sentence(kind, script=script, jobs=listed(waited, 'none'))


DECIDING = (cell_commands, job_queue, manual, operators, service)
"""The modules with the deciders of all requests."""


def answer_to(command: Command, ledger: Ledger) -> str:
    """Carry out a command and return the answer's words.

    :raises CommandRefused: its sender has no permission, or is not where it may be asked from, or
        it cannot be carried out now; nothing was recorded
    """
    if isinstance(command, Shutdown):
        return _shut_down(ledger)
    if isinstance(command, FoundTwin):
        return _stand_for_a_twin(command, ledger)
    why_not = not_allowed(command)
    if why_not is not None:
        raise CommandRefused(why_not)
    if isinstance(command, RefusedRequest):
        raise CommandRefused(command.message, command.each)
    why_not = not_from_there(ledger.state, command)
    if why_not is not None:
        raise CommandRefused(why_not)
    refuse_unsafe(ledger.state, command)
    request = command.request
    message, events = DECIDERS[request.name](ledger.state, command, ledger.now)
    if not request.takes_orders:  # else each order has its own record
        code = command.arguments.get(CODE.name, '') if isinstance(command, Asked) else ''
        record = decided(request.word, command.by, code=code, **command.about)
        events = chain(record, events)
    ledger.record(chain(signature(command.by, ledger.state), events))
    return message


def _stand_for_a_twin(command: FoundTwin, ledger: Ledger) -> str:
    """Start nothing more until an operator has checked the line; running goals continue."""
    state = ledger.state
    twins = [hold.message for hold in state.pauses if hold.reason == TWIN]
    if command.where not in twins and len(twins) < TWINS:
        hold = state.next_hold
        answers = (cell_commands.RESUME,)
        twin = e.HoldRaised(hold=hold, reason=TWIN, message=command.where, answers=answers)
        ledger.record([twin])
    return sentence('twin_stops', words=command.where)


def _shut_down(ledger: Ledger) -> str:
    """Cancel every goal and start nothing more: the node ends (semantics 2.6)."""
    state = ledger.state
    ledger.record([e.OrchestratorStopping()])
    if Cause.STOP in TRANSITIONS[state.packml]:
        ledger.record([transition(state.packml, Cause.STOP, SHUTDOWN)])
    # Goals cancelled by `abort` stay in doubt.
    running = [key for key, task in state.running.items() if task.cancel_cause != ABORT]
    ledger.record(effects.cancelled(state, running, SHUTDOWN))
    return effects.cancelled_words(len(running))
