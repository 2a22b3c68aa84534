"""The record of every command, carried out or refused: who, from where and why."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from bt_orchestrator.errors import CommandRefused
from bt_orchestrator.model import events as e
from bt_orchestrator.model.by import By
from bt_orchestrator.model.commands import OnRecord, RefusedRequest
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.requests import ADD


def decided(command: OnRecord) -> Iterator[e.Event]:
    """Yield the record of a command that is carried out; it precedes the command's events."""
    if command.by is not None:
        verb, about = _what(command)
        yield e.OperatorDecided(answer=verb, **_said(command.by), **about)


def decided_to_add(job: str, by: By | None) -> Iterator[e.Event]:
    """Yield the record for one added job."""
    if by is not None:
        yield e.OperatorDecided(answer=ADD.word, **_said(by), job=job)


def refused(command: OnRecord, why: CommandRefused) -> Iterator[e.OperatorRefused]:
    """Yield the record of a refused command, one for each job that it names."""
    if command.by is None:
        return
    verb, about = _what(command)
    for job, message in _each(command, why):
        told = {'job': job, **about} if job else about
        yield e.OperatorRefused(command=verb, **_said(command.by), **told, message=message)


def _said(by: By) -> dict[str, Any]:
    """Return the recorded fields of the sender."""
    return {
        'who': by.who,
        'origin': by.origin,
        'reason': by.reason,
        'role': by.role.value,
        'known': by.known.value,
        'claims': by.claims,
    }


def _each(command: OnRecord, why: CommandRefused) -> list[tuple[str, str]]:
    """Return the jobs that were to be added or changed, with the message for each."""
    match command:
        case AddJobs(jobs):
            names = tuple(job.id for job in jobs)
        case RefusedRequest(jobs=names):
            pass
        case _:
            names = ()
    if not names:
        return [('', str(why))]
    each = why.each or (str(why),) * len(names)
    return list(zip(names, each, strict=True))


def _what(command: OnRecord) -> tuple[str, dict[str, Any]]:
    """Return the command's word, and the field of its record that names its subject."""
    if isinstance(command, RefusedRequest):
        return command.verb, {}
    request = command.request
    return request.word, {request.recorded: command.subject} if request.subject else {}
