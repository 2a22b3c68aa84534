"""Which requests are possible now: `packml`, `job_control` and `failures` decide it."""

from __future__ import annotations

from collections.abc import Iterable

from bt_orchestrator.model.jobs import job_control
from bt_orchestrator.model.jobs.isa95 import JobWord
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


def of_job(word: JobWord, ending: str = '', *, awaits_start: bool = False) -> tuple[Request, ...]:
    """Return the requests to a job that a state allows.

    :param ending: `stopping` or `aborting` if the job already ends
    :param awaits_start: the job waits for the start of its order (semantics 6.7)
    """
    is_queued = word in (JobWord.NOT_ALLOWED_TO_START, JobWord.ALLOWED_TO_START)
    places = (MOVE, NEXT) if is_queued else ()
    fitting = (
        request
        for method, request in JOB
        if job_control.refusal(method, '', word, ending, awaits_start=awaits_start) is None
    )
    return (*places, *fitting)


def of_hold(answers: Iterable[str]) -> tuple[Request, ...]:
    """Return the requests behind the answers that a hold offers, in its order."""
    others = {VERBS[Cause.UNHOLD]: CELL[Cause.UNHOLD], REMOVE_ITEM.word: REMOVE_ITEM}
    known = {**ANSWERS, **others}
    return tuple(known[answer] for answer in answers if answer in known)
