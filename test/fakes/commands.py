"""Requests as tests write them, one function each."""
# ruff: noqa: N802

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from bt_orchestrator.model.by import By
from bt_orchestrator.model.judging.belt_statement import Statement
from bt_orchestrator.model.packml import Cause
from bt_orchestrator.model.requests import (
    ARRANGE,
    CELL,
    IN_SERVICE,
    MOVE,
    NEXT,
    OUT_OF_SERVICE,
    RELEASE_SCRIPT,
    REMOVE_ITEM,
    STOP_AFTERS,
    About,
    Asked,
    of_word,
)

CellCommand = Callable[..., Asked]
"""One of the functions that are about the cell."""


def AnswerHold(hold: str, answer: str, by: By, results: Mapping[str, Any] | None = None) -> Asked:
    request = of_word(About.HOLD, answer)
    assert request is not None, answer
    return Asked(request, by, {'hold': hold, **({'results': results} if results else {})})


def RemoveItem(item: str, by: By) -> Asked:
    return Asked(REMOVE_ITEM, by, {'item': item})


def SetService(component: str, in_service: bool, by: By) -> Asked:
    request = IN_SERVICE if in_service else OUT_OF_SERVICE
    return Asked(request, by, {'component': component})


def ReleaseScript(digest: str, by: By | None = None, cell_digest: str = '') -> Asked:
    return Asked(RELEASE_SCRIPT, by, {'script': digest, 'cell_digest': cell_digest})


def Arrange(jobs: Sequence[str], queue_digest: str, by: By) -> Asked:
    return Asked(ARRANGE, by, {'jobs': list(jobs), 'queue_digest': queue_digest})


def Reset(by: By) -> Asked:
    return Asked(CELL[Cause.RESET], by)


def Start(by: By) -> Asked:
    return Asked(CELL[Cause.START], by)


def Pause(by: By) -> Asked:
    return Asked(CELL[Cause.HOLD], by)


def Resume(by: By, hold: str | None = None, everyones: bool = False) -> Asked:
    named = {} if hold is None else {'hold': hold}
    return Asked(CELL[Cause.UNHOLD], by, {**named, 'everyones': everyones})


def Stop(by: By) -> Asked:
    return Asked(CELL[Cause.STOP], by)


def Abort(by: By) -> Asked:
    return Asked(CELL[Cause.ABORT], by)


def Clear(by: By, belt: Statement) -> Asked:
    return Asked(CELL[Cause.CLEAR], by, {'belt': belt})


def MoveJob(job: str, position: int, by: By) -> Asked:
    return Asked(MOVE, by, {'job': job, 'position': position})


def RunNext(job: str, by: By) -> Asked:
    return Asked(NEXT, by, {'job': job})


def ControlJob(verb: str, job: str, by: By) -> Asked:
    request = of_word(About.JOB, verb)
    assert request is not None, verb
    return Asked(request, by, {'job': job})


def StopAfter(after: str, by: By) -> Asked:
    return Asked(STOP_AFTERS[after], by)
