"""The requests that a reader may make (semantics 7.1), and those that would change something."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from bt_orchestrator.model.by import Control, Role
from bt_orchestrator.model.events import INDEX_KEY
from bt_orchestrator.model.failures import MARK_DONE, REJECT, SKIP
from bt_orchestrator.model.goal import Reason
from bt_orchestrator.model.jobs import job_control
from bt_orchestrator.model.jobs.isa95 import OVER, QUEUED
from bt_orchestrator.model.jobs.job_control import JobFacts, refusal
from bt_orchestrator.model.packml import (
    MANUAL_FROM,
    NOT_IN_MANUAL,
    Cause,
    PackmlState,
    UnitMode,
    possible_in,
)
from bt_orchestrator.model.requests.request import About, Request
from bt_orchestrator.model.requests.table import (
    CELL,
    CONTROLS,
    IN_SERVICE,
    MOVE,
    NEXT,
    OUT_OF_SERVICE,
    STOP_AFTERS,
    UNIT_MODES,
    of_word,
    requests_about,
)
from bt_orchestrator.model.script import Task
from bt_orchestrator.model.state import Hold
from bt_orchestrator.model.status import CellStatus, ComponentStatus
from bt_orchestrator.model.stop_reason import NEVER, STOP_AFTER
from bt_orchestrator.model.words import sentence


class Addressed(NamedTuple):
    """A request, and the argument that names its subject."""

    request: Request
    arguments: Mapping[str, str]


def of_cell(
    state: PackmlState, mode: UnitMode = UnitMode.PRODUCTION, *, is_broken: bool = False
) -> tuple[Request, ...]:
    """Return the requests to the cell that a state allows; only `abort` if it is broken."""
    if is_broken:
        return (CELL[Cause.ABORT],)
    kept = NOT_IN_MANUAL if mode is UnitMode.MANUAL else ()
    possible = (CELL[cause] for cause in possible_in(state) if cause not in kept)
    return (*possible, *STOP_AFTERS.values())


def of_job(facts: JobFacts) -> tuple[Request, ...]:
    """Return the requests that can be made of a job now."""
    places = (MOVE, NEXT) if facts.word in QUEUED else ()
    fitting = (
        request
        for request in requests_about(About.JOB)
        if request.method is not None and refusal(request.method, '', facts) is None
    )
    return (*places, *fitting)


def of_hold(answers: Iterable[str]) -> tuple[Request, ...]:
    """Return the requests behind the answers that a hold offers, in its order."""
    return tuple(_ANSWERING[answer] for answer in answers if answer in _ANSWERING)


def possible_answers() -> tuple[str, ...]:
    """Return every answer that decides about a task or an item."""
    return tuple(word for word, request in _ANSWERING.items() if request.about is not About.CELL)


def answering(hold: Hold, answer: str) -> Addressed:
    """Return the request that an answer to a hold stands for, or a remark about it.

    :raises KeyError: the hold does not offer it
    """
    known = {offer.word: offer for offer in (*of_hold(hold.answers), *_REMARKS)}
    request = known[answer]
    is_of_item = request.about is About.ITEM
    return Addressed(request, {'item': hold.item or ''} if is_of_item else {'hold': hold.id})


_ABOUT_HOLDS = requests_about(About.HOLD)
_REMARKS = tuple(request for request in _ABOUT_HOLDS if request.is_remark)
_ANSWERING: Mapping[str, Request] = {
    request.word: request
    for request in (*_ABOUT_HOLDS, *requests_about(About.ITEM), CELL[Cause.UNHOLD])
    if not request.is_remark
}


_PEOPLE = {
    Role.VIEW: 'a viewer',
    Role.MES: 'an MES',
    Role.OPERATE: 'an operator',
    Role.ENGINEER: 'an engineer',
}


def may_make(request: Request, role: Role | None) -> bool:
    """Tell whether a role may make a request.

    :param role: of the reader; None: not known, so nothing is kept from the reader
    """
    return role is None or role in request.roles


def allowed(answers: Iterable[str], role: Role | None) -> list[str]:
    """Return the answers to a hold that a role may give."""
    return [request.word for request in of_hold(answers) if may_make(request, role)]


def roles_of(answers: Iterable[str]) -> dict[str, list[str]]:
    """Return the roles that may give each of the answers to a hold."""
    return {
        request.word: [role.value for role in Role if role in request.roles]
        for request in of_hold(answers)
    }


def role_words(answers: Sequence[str]) -> list[str]:
    """Return for each of the answers to a hold the roles that may give it, as one text."""
    roles = roles_of(answers)
    return [' or '.join(roles.get(answer, ())) for answer in answers]


def who_may(request: Request) -> str:
    """Name the people who may make a request, for instance an operator or an engineer."""
    return ' or '.join(_PEOPLE[role] for role in Role if role in request.roles)


def offer_words(answers: Sequence[str], role: Role | None) -> str:
    """Name the answers that a role may give, and who may give the others."""
    mine = ', '.join(allowed(answers, role))
    return '; '.join(filter(None, (mine, *answers_of_others(answers, role))))


def answers_of_others(answers: Sequence[str], role: Role | None) -> list[str]:
    """Say who may give the answers to a hold that a role may not give."""
    words: dict[str, list[str]] = {}
    for request in of_hold(answers):
        if not may_make(request, role):
            words.setdefault(who_may(request), []).append(request.word)
    kind = 'may_also_answer' if allowed(answers, role) else 'may_answer'
    return [sentence(kind, people=who, replies=', '.join(names)) for who, names in words.items()]


# The possible requests that would change something now: a surface offers no others.

_STOPPED = (
    PackmlState.STOPPING,
    PackmlState.STOPPED,
    PackmlState.ABORTING,
    PackmlState.ABORTED,
    PackmlState.CLEARING,
)
"""Where it makes no difference that the line is to run empty and stop."""


def worthwhile_for_cell(status: CellStatus) -> Iterator[Request]:
    """Yield the requests to the cell that it allows and that would change it."""
    for word in status.commands:
        request = of_word(About.CELL, word)
        if request is not None and _changes_cell(request, status):
            yield request
    if status.journal_failure:
        return
    if status.unit_mode is UnitMode.MANUAL:
        yield UNIT_MODES[UnitMode.PRODUCTION]
        return
    yield from (request for control, request in CONTROLS.items() if control is not status.control)
    if status.control is Control.LOCAL and status.state in MANUAL_FROM:
        yield UNIT_MODES[UnitMode.MANUAL]


def _changes_cell(request: Request, status: CellStatus) -> bool:
    waits = any(job.state not in OVER for job in status.jobs)
    match request.cause:
        case Cause.UNHOLD:
            return any(hold.is_pause and not hold.must_be_named for hold in status.holds)
        case Cause.CLEAR:
            return not any(hold.key == INDEX_KEY for hold in status.holds)  # has the belt moved?
        case Cause.START:
            return waits or bool(status.waits_for)
        case Cause.RESET:
            return waits or status.state is PackmlState.STOPPED
        case None:
            return _changes_stop(request.word.removeprefix(STOP_AFTER), status)
    return True


def _changes_stop(after: str, status: CellStatus) -> bool:
    if after == NEVER:
        return bool(status.stop_after)
    is_begun = any(job.state not in OVER and not job.position for job in status.jobs)
    return is_begun and after != status.stop_after and status.state not in _STOPPED


def worthwhile_for_component(component: ComponentStatus) -> Request:
    """Return the request to a component that would change it."""
    return OUT_OF_SERVICE if component.out_of_service_since is None else IN_SERVICE


@dataclass(frozen=True)
class JobNow:
    """The facts that decide which requests to a job would change something."""

    facts: JobFacts
    has_back: bool
    """It was made without a component that is in service again."""
    is_next: bool
    """It is the first one in the queue."""
    is_alone: bool
    """No other job is in the queue."""
    is_cell_stopped: bool
    """A person has stopped it; then every job on it has the word of a pause."""


def worthwhile_for_job(now: JobNow) -> tuple[Request, ...]:
    """Return the requests to a job that its state allows and that would change it."""
    facts = now.facts
    nothing_new = {
        MOVE.word: now.is_alone,
        NEXT.word: now.is_next and not facts.is_held and not facts.awaits_start,
        job_control.RESUME.verb: now.is_cell_stopped,
        job_control.REQUEUE.verb: not facts.unavailable and not now.has_back,
    }
    return tuple(request for request in of_job(facts) if not nothing_new.get(request.word, False))


# Holds that ask the same: one list may carry their answers.
#
# After a restart every goal in flight can be such a question. Each answer of a list is a request
# and a record of its own. Answered singly are the belt, tasks that place or take out an item, and
# every answer that moves something again.

TOGETHER = (MARK_DONE, SKIP, REJECT)
"""Answers that a list may carry."""


def together(hold: Hold, task: Task, offered: Iterable[str]) -> tuple[str, ...]:
    """Return the answers to a hold that a list may carry; none: it is answered singly.

    :param task: the one that is held
    """
    is_doubt = hold.reason == Reason.IN_DOUBT.value and hold.job is not None
    if not is_doubt or task.qty_change:
        return ()
    return tuple(answer for answer in offered if answer in TOGETHER)


def alike(holds: Iterable[Hold]) -> list[Sequence[Hold]]:
    """Return the groups of two or more holds that a list may answer, in the order of the holds."""
    groups: dict[tuple[str, ...], list[Hold]] = {}
    for hold in holds:
        answers = hold.answers_together
        if answers:
            groups.setdefault(tuple(sorted(answers)), []).append(hold)
    return [group for group in groups.values() if len(group) > 1]


def why_singly(hold: Hold, answer: str) -> str:
    """Say why a list may not carry an answer to a hold; empty: it may."""
    possible = hold.answers_together
    if answer in possible:
        return ''
    offered = (
        f'a list can answer it with {", ".join(possible)}' if possible else 'answer it singly'
    )
    return f'hold {hold.id} ({hold.task or "the cell"}: {hold.reason}): {offered}; found {answer}'
