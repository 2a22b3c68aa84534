"""The routes of a planner: what-if, the check of an order, and the queue beyond the status."""

from __future__ import annotations

from collections.abc import Awaitable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Protocol

from starlette.requests import Request
from starlette.responses import Response

from bt_orchestrator.base.errors import CommandRefused, NodeUnreachable, NotKept
from bt_orchestrator.extensions.page.web.endpoint import Endpoint, Json, Problem, Schema, body_of
from bt_orchestrator.extensions.page.web.planning.questions import (
    Questions,
    TooManyQuestions,
    Withdrawn,
    asked_of,
)
from bt_orchestrator.model.frozen import changed
from bt_orchestrator.model.limits import QUEUE_SHOWN
from bt_orchestrator.model.status import CellStatus, JobStatus
from bt_orchestrator.ports import QueuePage

if TYPE_CHECKING:
    from bt_orchestrator.extensions.page.web.page import WebPage


MOST_COMMANDS = 50

_COMMANDS: Schema = {
    'type': 'array',
    'maxItems': MOST_COMMANDS,
    'items': {
        'type': 'object',
        'required': ['name'],
        'properties': {'name': {'type': 'string'}, 'arguments': {'type': 'object'}},
    },
}

_UNKNOWN = {503: 'it cannot be worked out now: the message says why'}


class Queue(Protocol):
    """The needs of these routes from the rest of the page."""

    @property
    def queued(self) -> int:
        """Length of the queue, as far as is known."""

    async def page(self, after: str, most: int) -> QueuePage:
        """Return jobs of the queue, in order.

        :raises CommandRefused: `after` is not in the queue
        :raises NodeUnreachable: the node does not answer
        """

    def shown(self, jobs: Sequence[JobStatus]) -> Sequence[object]:
        """Return jobs as the page shows them."""


def endpoints(questions: Questions, queue: Queue) -> tuple[Endpoint, ...]:
    """Return the endpoints."""
    routes = _Routes(questions, queue)
    return (
        Endpoint(
            'POST',
            '/api/what-if',
            routes.what_if,
            'predicts when every job ends, without and with some requests; nothing is done',
            body={'commands': _COMMANDS},
            required=('commands',),
            refusals=_UNKNOWN,
        ),
        Endpoint(
            'POST',
            '/api/queue/propose',
            routes.propose,
            'proposes an order of the queue, with the offer that applies it; nothing is done',
            refusals=_UNKNOWN,
        ),
        Endpoint(
            'POST',
            '/api/orders/check',
            routes.check,
            'tells whether an order would be queued, each mistake at its key; nothing is done',
            body={'order': {'type': 'object'}},
            required=('order',),
            refusals=_UNKNOWN,
        ),
        Endpoint(
            'GET',
            '/api/queue',
            routes.queue,
            f'returns jobs of the queue in order, {QUEUE_SHOWN} at a time',
            query={'after': 'the job before the first to return; absent: from the first'},
            refusals={409: 'that job is not in the queue', **_UNKNOWN},
        ),
    )


class _Routes:
    def __init__(self, questions: Questions, queue: Queue) -> None:
        self._questions = questions
        self._queue = queue

    async def what_if(self, request: Request) -> Response:
        commands = (await body_of(request)).get('commands')
        if not isinstance(commands, list) or len(commands) > MOST_COMMANDS:
            raise Problem(422, f'commands are a list of at most {MOST_COMMANDS}')
        try:
            asked = [asked_of(command) for command in commands]
        except ValueError as error:
            raise Problem(422, str(error)) from error
        return await _answered(
            self._questions.what_if(asked, self._queue.queued, request.is_disconnected)
        )

    async def propose(self, request: Request) -> Response:
        asked = self._questions.propose(self._queue.queued, request.is_disconnected)
        return await _answered(asked)

    async def check(self, request: Request) -> Response:
        order = (await body_of(request)).get('order')
        if not isinstance(order, Mapping):
            raise Problem(422, 'order is an object with the keys of an order file')
        return await _answered(self._questions.check(order, request.is_disconnected))

    async def queue(self, request: Request) -> Response:
        after = request.query_params.get('after', '')
        try:
            page = await self._queue.page(after, QUEUE_SHOWN)
        except CommandRefused as refused:
            raise Problem(409, str(refused)) from refused
        except NodeUnreachable as error:
            raise Problem(503, str(error)) from error
        last = page.jobs[-1] if page.jobs else None
        is_end = last is None or last.position >= page.queued
        return Json(
            {
                'jobs': list(self._queue.shown(page.jobs)),
                'queued': page.queued,
                'rest': None if is_end or last is None else last.id,
            }
        )


async def _answered(question: Awaitable[Any]) -> Response:
    try:
        return Json(await question)
    except (NodeUnreachable, NotKept, TooManyQuestions, Withdrawn) as error:
        raise Problem(503, str(error)) from error


# The whole queue of a page's cell, also what its status does not list.


class PageQueue:
    """Implements `endpoints.Queue`."""

    def __init__(self, page: WebPage) -> None:
        self._page = page

    @property
    def queued(self) -> int:
        """Length of the queue, as far as is known."""
        status = self._page.board.status
        return status.queued if status else 0

    async def page(self, after: str, most: int) -> QueuePage:
        """Return jobs of the queue, in order.

        :raises CommandRefused: `after` is not in the queue
        :raises NodeUnreachable: the node does not answer
        """
        return await self._page.doors.queue(after, most)

    def shown(self, jobs: Sequence[JobStatus]) -> Sequence[object]:
        """Return jobs as the page shows those of the status."""
        status = self._page.board.status
        if status is None:
            return ()
        alone: CellStatus = changed(status, jobs=tuple(jobs), sections=(), holds=(), components=())
        parts = self._page.show.parts(alone, self._page.description, self._page.doors.name)
        return [parts[f'job/{job.id}'] for job in jobs]
