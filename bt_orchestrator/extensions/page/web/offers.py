"""Requests that are possible now, ready to be sent: path and body stand in each offer.

A request that would be refused or would change nothing in the present state is not offered. Roles
are not looked at here: an offer says for which it is.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache

from bt_orchestrator.extensions.page.web.request_paths import ANY
from bt_orchestrator.model.by import Role
from bt_orchestrator.model.jobs.job_control import JobFacts
from bt_orchestrator.model.packml import Cause, UnitMode
from bt_orchestrator.model.requests import (
    REQUESTS,
    About,
    Request,
    of_hold,
    requests_about,
)
from bt_orchestrator.model.requests.offers import (
    JobNow,
    worthwhile_for_cell,
    worthwhile_for_component,
    worthwhile_for_job,
)
from bt_orchestrator.model.state import Hold
from bt_orchestrator.model.status import CellStatus, ComponentStatus, ItemStatus, JobStatus
from bt_orchestrator.model.stop_reason import StopReason

Offer = dict[str, object]

_NOTHING: Mapping[str, object] = {}

_OF_A_HOLD = ('hold', 'code')
"""Arguments of `resume` where it is not about one hold."""


def cell_offers(status: CellStatus) -> list[Offer]:
    """Return what can be asked of the cell."""
    return [_cell_offer(request, status) for request in worthwhile_for_cell(status)]


def _cell_offer(request: Request, status: CellStatus) -> Offer:
    shown = {'as_shown': status.seq} if request.name in _STATES_BELT else {}
    without = _OF_A_HOLD if request.cause is Cause.UNHOLD else ()
    return _offer(request, given=shown, without=without)


_STATES_BELT = ('cell.clear', 'cell.production')


def manual_offers(status: CellStatus) -> dict[str, Offer | None]:
    """Return what an engineer at a panel can ask in manual mode; None: it is not possible."""
    if status.unit_mode is not UnitMode.MANUAL:
        return {'run': None, 'cancel': None}
    goal = status.manual
    runs = goal is not None and goal.ended is None
    return {
        'run': {**_offer(REQUESTS['component.run_task']), 'body': {}},
        'cancel': _offer(REQUESTS['component.cancel_task'], goal.component)
        if goal is not None and runs
        else None,
    }


def hold_offers(hold: Hold) -> list[Offer]:
    """Return the answers to a hold, in its order; a pause is released."""
    return [_hold_offer(request, hold) for request in of_hold(hold.answers)]


def _hold_offer(request: Request, hold: Hold) -> Offer:
    match request.about:
        case About.ITEM:
            return _offer(request, hold.item or '')
        case About.CELL:
            return _offer(request, given={'hold': hold.id}, without=('everyones',))
    offer = _offer(request, hold.id)
    if hold.item is None:  # results belong to an item
        offer['parameters'] = list(_parameters(request, {'hold', 'results'}))
    return offer


def item_offers(item: ItemStatus | None) -> Sequence[Offer]:
    """Return what can be asked about the item in a slot."""
    return _item_offers(item.id) if item is not None and item.present else []


@lru_cache(maxsize=1024)
def _item_offers(item: str) -> Sequence[Offer]:
    return [_offer(request, item) for request in requests_about(About.ITEM)]


def component_offers(component: ComponentStatus) -> Sequence[Offer]:
    """Return what can be asked of a component."""
    return _component_offers(component.name, worthwhile_for_component(component))


@lru_cache(maxsize=1024)
def _component_offers(component: str, request: Request) -> Sequence[Offer]:
    return [_offer(request, component)]


def job_offers(job: JobStatus, status: CellStatus) -> Sequence[Offer]:
    """Return what can be asked of a job."""
    facts = JobFacts(
        job.state,
        job.ending,
        job.awaits_start,
        job.unreleased,
        job.unavailable,
        job.held,
        job.by_recipe,
        left=min(job.to_begin, 1),  # whether any is left: the number changes too often
        piece=job.awaited_piece,
        piece_left=job.first_piece_state,
    )
    return _job_offers(
        job.id,
        JobNow(
            facts,
            has_back=bool(back_for(job, status)),
            is_next=job.position == 1,
            is_alone=status.queued <= 1,
            is_cell_stopped=status.stop_reason is StopReason.OPERATOR,
        ),
    )


@lru_cache(maxsize=1024)
def _job_offers(job: str, now: JobNow) -> Sequence[Offer]:
    """Return the offers of a job, cached: each status tells 100 jobs of a long queue."""
    unreleased = now.facts.unreleased
    of_script = requests_about(About.SCRIPT) if unreleased else ()
    release = (_offer(request, unreleased, without=('cell_digest',)) for request in of_script)
    return [*release, *(_offer(request, job) for request in worthwhile_for_job(now))]


def back_for(job: JobStatus, status: CellStatus) -> list[str]:
    """Return the components that a job was made without, and that are in service again."""
    without = job.anew.without if job.anew is not None else ()
    there = (
        component.name for component in status.components if component.out_of_service_since is None
    )
    return [name for name in there if name in without]


def classify_offer() -> Offer:
    """Return what is always possible: to say the reason of a stop; which one is said then."""
    (classify,) = requests_about(About.STOP)
    return {**_offer(classify), 'body': {}}


def add_offer() -> Offer:
    """Return what is always possible: to queue orders."""
    add, _ = requests_about(About.QUEUE)
    return _offer(add)


def arrange_offer(order: Sequence[str], queue_digest: str) -> Offer:
    """Return the offer to put the queue into an order that was proposed for it."""
    _, arrange = requests_about(About.QUEUE)
    return _offer(arrange, given={'jobs': list(order), 'queue_digest': queue_digest})


def _offer(
    request: Request,
    subject: str = '',
    given: Mapping[str, object] = _NOTHING,
    without: Sequence[str] = (),
) -> Offer:
    """Return an offer.

    :param subject: id of its hold, item, job, component or script
    :param given: arguments that are settled
    :param without: parameters that this offer has no use for
    """
    about = {request.subject.name: subject} if request.subject else {}
    body = {**about, **given}
    return {
        'name': request.name,
        'word': request.word,
        'effect': request.effect,
        'why': request.why.value,
        'is_confirmed': request.is_confirmed,
        'moves': request.moves,
        'roles': _roles(request.roles),
        'path': ANY.format(name=request.name),
        'subject': subject,
        'body': body,
        'parameters': list(_parameters(request, {*body, *without})),
        'foresee': {'name': request.name, 'arguments': body} if request.is_foreseen else None,
    }


def _parameters(request: Request, given: set[str]) -> Iterator[dict[str, object]]:
    for parameter in request.parameters:
        if parameter.name not in given:
            yield {
                'name': parameter.name,
                'kind': parameter.kind.value,
                'meaning': parameter.meaning,
                'is_required': parameter.is_required,
                'choices': list(parameter.choices),
                'roles': _roles(parameter.roles or request.roles),
            }


def _roles(roles: frozenset[Role]) -> list[str]:
    return [role.value for role in Role if role in roles]
