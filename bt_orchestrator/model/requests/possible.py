"""Which requests are possible now: `packml`, `job_control` and `failures` decide it."""

from __future__ import annotations

from collections.abc import Iterable

from bt_orchestrator.model.jobs.isa95 import QUEUED
from bt_orchestrator.model.jobs.job_control import JobFacts, refusal
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


def of_job(facts: JobFacts) -> tuple[Request, ...]:
    """Return the requests that can be made of a job now."""
    places = (MOVE, NEXT) if facts.word in QUEUED else ()
    fitting = (request for method, request in JOB if refusal(method, '', facts) is None)
    return (*places, *fitting)


def of_hold(answers: Iterable[str]) -> tuple[Request, ...]:
    """Return the requests behind the answers that a hold offers, in its order."""
    others = {VERBS[Cause.UNHOLD]: CELL[Cause.UNHOLD], REMOVE_ITEM.word: REMOVE_ITEM}
    known = {**ANSWERS, **others}
    return tuple(known[answer] for answer in answers if answer in known)
