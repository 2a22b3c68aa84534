"""The requests that are possible now: `packml`, `job_control` and `failures` decide it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from bt_orchestrator.model.jobs.isa95 import QUEUED
from bt_orchestrator.model.jobs.job_control import JobFacts, refusal
from bt_orchestrator.model.packml import Cause, PackmlState, possible_in
from bt_orchestrator.model.requests.request import About, Request
from bt_orchestrator.model.requests.table import (
    CELL,
    MOVE,
    NEXT,
    STOP_AFTERS,
    requests_about,
)
from bt_orchestrator.model.state import Hold


class Addressed(NamedTuple):
    """A request, and the argument that names its subject."""

    request: Request
    arguments: Mapping[str, str]


def of_cell(state: PackmlState, *, is_broken: bool = False) -> tuple[Request, ...]:
    """Return the requests to the cell that a state allows; only `abort` if it is broken."""
    if is_broken:
        return (CELL[Cause.ABORT],)
    return (*(CELL[cause] for cause in possible_in(state)), *STOP_AFTERS.values())


def of_job(facts: JobFacts) -> tuple[Request, ...]:
    """Return the requests that can be made of a job now."""
    places = (MOVE, NEXT) if facts.word in QUEUED else ()
    fitting = (
        one
        for one in requests_about(About.JOB)
        if one.method is not None and refusal(one.method, '', facts) is None
    )
    return (*places, *fitting)


def of_hold(answers: Iterable[str]) -> tuple[Request, ...]:
    """Return the requests behind the answers that a hold offers, in its order."""
    return tuple(_ANSWERING[answer] for answer in answers if answer in _ANSWERING)


def possible_answers() -> tuple[str, ...]:
    """Return every answer that decides about a task or an item."""
    return tuple(word for word, one in _ANSWERING.items() if one.about is not About.CELL)


def answering(hold: Hold, answer: str) -> Addressed:
    """Return the request that an answer to a hold stands for, or a remark about it.

    :raises KeyError: the hold does not offer it
    """
    known = {one.word: one for one in (*of_hold(hold.answers), *_REMARKS)}
    request = known[answer]
    is_of_item = request.about is About.ITEM
    return Addressed(request, {'item': hold.item or ''} if is_of_item else {'hold': hold.id})


_ABOUT_HOLDS = requests_about(About.HOLD)
_REMARKS = tuple(one for one in _ABOUT_HOLDS if one.is_remark)
_ANSWERING: Mapping[str, Request] = {
    one.word: one
    for one in (*_ABOUT_HOLDS, *requests_about(About.ITEM), CELL[Cause.UNHOLD])
    if not one.is_remark
}
