"""What each command does: events, or a refusal with the reason."""

from __future__ import annotations

from bt_orchestrator.model import events as e
from bt_orchestrator.model.commands import (
    AnswerHold,
    Command,
    Pause,
    RemoveItem,
    Resume,
    Shutdown,
    SubmitJob,
)
from bt_orchestrator.model.failures import SHUTDOWN
from bt_orchestrator.model.packml import Mode
from bt_orchestrator.runtime import job_queue, operators, orders
from bt_orchestrator.runtime.ledger import Ledger


def answer_to(command: Command, ledger: Ledger) -> str:
    """Carry out a command and return the answer's words.

    :raises CommandRefused: it cannot be carried out now; nothing was recorded
    """
    if isinstance(command, SubmitJob):
        ledger.record(orders.queue(ledger.state, [command.job]))
        return f'{command.job.id} is queued'
    if isinstance(command, AnswerHold):
        ledger.record(operators.answer(ledger.state, command, ledger.now))
        return f'hold {command.hold}: {command.answer}'
    if isinstance(command, RemoveItem):
        ledger.record(operators.remove(ledger.state, command))
        return f'{command.item} is off the belt'
    if isinstance(command, Pause):
        ledger.record(operators.pause(ledger.state, command))
        return 'the cell starts nothing more'
    if isinstance(command, Resume):
        ledger.record(list(operators.resume(ledger.state, command)))
        return 'the cell goes on'
    if isinstance(command, Shutdown):
        return _shut_down(ledger)
    message, events = job_queue.carry_out(command, ledger.state)
    ledger.record(events)
    return message


def _shut_down(ledger: Ledger) -> str:
    mode = ledger.state.mode
    if mode not in (Mode.STOPPED, Mode.STOPPING):
        stopping = e.CellStateChanged(
            state=Mode.STOPPING.value, previous=mode.value, reason='shutdown'
        )
        ledger.record([stopping])
    running = list(ledger.state.running.items())
    for key, task in running:
        assert task.goal is not None
        cancel = e.TaskCancelRequested(**key._asdict(), goal=task.goal, cause=SHUTDOWN)
        ledger.record([cancel])
    return f'{len(running)} goals are being cancelled'
