"""Which requests are possible now: `packml`, `job_control` and `failures` decide it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bt_orchestrator.model.jobs import job_control
from bt_orchestrator.model.jobs.isa95 import QUEUED, JobWord
from bt_orchestrator.model.packml import VERBS, Cause, PackmlState, possible_in
from bt_orchestrator.model.requests.request import Request
from bt_orchestrator.model.requests.table import (
    ANSWERS,
    CELL,
    JOB,
    MOVE,
    NEXT,
    REMOVE_ITEM,
    STOP_AFTERS,
)


def of_cell(state: PackmlState) -> tuple[Request, ...]:
    """Return the requests to the cell that a state allows; only `abort` if it is broken."""
    return (*(CELL[cause] for cause in possible_in(state)), *STOP_AFTERS.values())


def of_job(
    word: JobWord,
    ending: str = '',
    *,
    awaits_start: bool = False,
    unreleased: str = '',
    unavailable: Sequence[str] = (),
    is_held: bool = True,
    is_by_recipe: bool = True,
    left: int = 1,
) -> tuple[Request, ...]:
    """Return the requests to a job that a state allows; see `job_control.refusal`."""
    is_queued = word in QUEUED
    places = (MOVE, NEXT) if is_queued else ()
    fitting = (
        request
        for method, request in JOB
        if job_control.refusal(
            method,
            '',
            word,
            ending,
            awaits_start=awaits_start,
            unreleased=unreleased,
            unavailable=unavailable,
            is_held=is_held,
            is_by_recipe=is_by_recipe,
            left=left,
        )
        is None
    )
    return (*places, *fitting)


def of_hold(answers: Iterable[str]) -> tuple[Request, ...]:
    """Return the requests behind the answers that a hold offers, in its order."""
    others = {VERBS[Cause.UNHOLD]: CELL[Cause.UNHOLD], REMOVE_ITEM.word: REMOVE_ITEM}
    known = {**ANSWERS, **others}
    return tuple(known[answer] for answer in answers if answer in known)
