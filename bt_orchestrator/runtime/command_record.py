"""What is put on record of every command, carried out or refused: who, from where and why."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from bt_orchestrator.model import events as e
from bt_orchestrator.model.by import By
from bt_orchestrator.model.cell_commands import CellCommand
from bt_orchestrator.model.commands import AnswerHold, OnRecord, RemoveItem
from bt_orchestrator.model.job_commands import (
    AddJobs,
    ControlJob,
    MoveJob,
    RunNext,
    StopAfter,
    UpdateJob,
)
from bt_orchestrator.model.packml import VERBS

ADD = 'add'


def decided(command: OnRecord) -> Iterator[e.Event]:
    """Yield the record of a command that is carried out; it stands in front of what it does."""
    if command.by is not None:
        verb, about = _what(command)
        yield e.OperatorDecided(answer=verb, **vars(command.by), **about)


def decided_to_add(job: str, by: By | None) -> Iterator[e.Event]:
    """Yield the record of one of the jobs that are added."""
    if by is not None:
        yield e.OperatorDecided(answer=ADD, **vars(by), job=job)


def refused(command: OnRecord, message: str) -> Iterator[e.Event]:
    """Yield the record of a command that was not carried out.

    :param message: why not
    """
    if command.by is not None:
        verb, about = _what(command)
        yield e.OperatorRefused(command=verb, **vars(command.by), **about, message=message)


def _what(command: OnRecord) -> tuple[str, dict[str, Any]]:
    """Return the word for a command, and the hold, job or item it is about."""
    match command:
        case AnswerHold(hold, answer):
            return answer, {'hold': hold}
        case RemoveItem(item):
            return 'remove_item', {'item': item}
        case CellCommand():
            return VERBS[command.cause], {}
        case AddJobs((job,)):
            return ADD, {'job': job.id}
        case AddJobs():
            return ADD, {}
        case MoveJob(name):
            return 'move', {'job': name}
        case RunNext(name):
            return 'next', {'job': name}
        case UpdateJob(job):
            return 'update', {'job': job.id}
        case ControlJob(verb, name):
            return verb, {'job': name}
        case StopAfter(after):
            return f'stop_after_{after}', {}
