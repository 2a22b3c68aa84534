"""The web application: all routes of the page, their description, and what stands before them."""

from __future__ import annotations

import asyncio
import re
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, Response
from starlette.routing import BaseRoute, Mount, Route
from starlette.staticfiles import StaticFiles

from bt_orchestrator.base.errors import JournalUnusable
from bt_orchestrator.extensions.page.web import (
    account,
    archive,
    commands,
    me,
    scripts,
    tree_watch,
)
from bt_orchestrator.extensions.page.web.endpoint import (
    HANDLERS,
    Endpoint,
    Json,
    Problem,
    Schema,
    routes,
)
from bt_orchestrator.extensions.page.web.guards import GuardMiddleware
from bt_orchestrator.extensions.page.web.planning import endpoints as planning
from bt_orchestrator.extensions.page.web.planning.endpoints import PageQueue
from bt_orchestrator.model.codec import to_plain
from bt_orchestrator.ports.records import PlantCell, PlantCells


def cells_endpoints(cells: PlantCells | None) -> tuple[Endpoint, ...]:
    """Return the endpoint.

    :param cells: reads them; None: the page was started without --plant
    """

    def plain(cell: PlantCell) -> Mapping[str, object]:
        is_address = cell.page.startswith(('http://', 'https://'))  # and no script for a browser
        return {**cell._asdict(), 'page': cell.page if is_address else ''}

    async def listed(_: Request) -> Response:
        if cells is None:
            return Json({'has_plant': False, 'cells': []})
        try:
            all_cells = await asyncio.to_thread(cells)
        except JournalUnusable as error:
            raise Problem(503, str(error)) from error
        return Json({'has_plant': True, 'cells': [plain(cell) for cell in all_cells]})

    return (
        Endpoint(
            'GET',
            '/api/cells',
            listed,
            'returns the cells of the plant (`--plant`), each with its state, the age of its copy '
            'and the address of its page; `has_plant` is false without a plant',
            refusals={503: "the plant's database cannot be read: the message says why"},
        ),
    )


if TYPE_CHECKING:
    from starlette.types import Receive, Scope, Send

    from bt_orchestrator.extensions.page.web.page import WebPage


STATIC = Path(__file__).parent / 'static'

FRESH = {'cache-control': 'no-cache'}
"""A browser asks whether a file has changed: after an update it must not mix old and new ones."""


def make_app(page: WebPage) -> Starlette:
    """Return the application of a page that was started."""
    app = Starlette(
        routes=routes_of(page), middleware=middleware_of(page), exception_handlers=HANDLERS
    )
    app.state.page = page
    return app


def routes_of(page: WebPage) -> list[BaseRoute]:
    """Return all routes."""
    return [
        Route('/', _index),
        *routes(with_description(endpoints_of(page))),
        Mount('/static', _Files(directory=STATIC)),
    ]


def endpoints_of(page: WebPage) -> list[Endpoint]:
    """Return all endpoints; each part of the page gives its own."""
    return [
        *_core(page),
        *me.endpoints(page.people),
        *commands.endpoints(page.tickets),
        *archive.endpoints(page.archive, page),
        *account.endpoints(page.shift, page),
        *cells_endpoints(page.sources.cells),
        *scripts.endpoints(page.shelf, page),
        *tree_watch.endpoints(page.tree, page),
        *planning.endpoints(page.questions, PageQueue(page)),
    ]


def middleware_of(page: WebPage) -> Sequence[Middleware]:
    """Return what every request passes, the outermost first."""
    return (Middleware(GuardMiddleware, people=page.people),)


async def _index(_: Request) -> Response:
    return FileResponse(STATIC / 'index.html', headers=FRESH)


def _core(page: WebPage) -> list[Endpoint]:
    async def healthz(_: Request) -> Response:
        return JSONResponse(
            {
                'node': page.doors.name,
                'heard': page.status is not None,
                'silent_s': round(page.doors.silent_s, 1),
                'readers': len(page.streams.readers),
            }
        )

    async def cell(_: Request) -> Response:
        if page.status is None:
            raise Problem(503, f'nothing was heard of {page.doors.name} yet')
        return Json(
            {
                'node': page.doors.name,
                'silent_s': round(page.doors.silent_s, 1),
                'description': to_plain(page.description, whole=True),
                'status': to_plain(page.status, whole=True),
            }
        )

    return [
        Endpoint(
            'GET',
            '/healthz',
            healthz,
            'the page is there; whether the node was heard, and how long it is silent',
        ),
        Endpoint(
            'GET', '/api/stream', _Stream(page), 'what happens, as server-sent events',
            query={'after': 'HISTORY:SEQ of the last event that is known; also Last-Event-ID'},
            media='text/event-stream',
        ),
        Endpoint(
            'GET', '/api/cell', cell, 'the newest status, as `status --json` prints it, and what '
            'exists in the cell', refusals={503: 'nothing was heard of the cell yet'},
        ),
    ]  # fmt: skip


class _Stream:
    """The stream as an ASGI application: starlette calls a function with a request instead."""

    def __init__(self, page: WebPage) -> None:
        self._page = page

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        await self._page.streams(scope, receive, send)


class _Files(StaticFiles):
    """The files of the page."""

    async def get_response(self, path: str, scope: Scope) -> Response:
        response = await super().get_response(path, scope)
        response.headers.update(FRESH)
        return response


# The description of the API (OpenAPI 3.1), made from the endpoints themselves.

OPENAPI_PATH = '/api/openapi.json'

_PARAMETER = re.compile(r'{(\w+)(?::\w+)?}')

_ALWAYS: Mapping[int, str] = {
    403: 'the Host or the Origin is not that of this page',
    401: 'log in first',
}
_OF_POSTS: Mapping[int, str] = {
    413: 'the body is too long',
    415: 'the body is not application/json',
    422: 'the body does not fit; `message` says what was expected',
}


def with_description(endpoints: Sequence[Endpoint]) -> Sequence[Endpoint]:
    """Return endpoints and the one that describes them all."""
    described: list[Endpoint] = []

    async def answer(_: Request) -> Response:
        return Json(document(described))

    own = Endpoint('GET', OPENAPI_PATH, answer, 'this description of the API')
    described += (*endpoints, own)
    return described


def document(endpoints: Sequence[Endpoint]) -> dict[str, Any]:
    """Return the description of some endpoints."""
    paths: dict[str, dict[str, Any]] = {}
    for endpoint in endpoints:
        path = _PARAMETER.sub(r'{\1}', endpoint.path)
        paths.setdefault(path, {})[endpoint.method.lower()] = _operation(endpoint)
    return {
        'openapi': '3.1.0',
        'info': {
            'title': 'The operator page of bt_orchestrator',
            'version': version('bt_orchestrator'),
            'description': 'A POST needs a session, an Origin header that is the address of the '
            'page, and a JSON object. Times are seconds since the epoch, durations seconds.',
        },
        'paths': paths,
        'components': {'schemas': {'Problem': _PROBLEM}},
    }


def _operation(endpoint: Endpoint) -> dict[str, Any]:
    refusals = {**_ALWAYS, **(_OF_POSTS if endpoint.method == 'POST' else {}), **endpoint.refusals}
    operation: dict[str, Any] = {
        'operationId': _id(endpoint),
        'summary': endpoint.does,
        'parameters': [
            *(_in_path(name) for name in _PARAMETER.findall(endpoint.path)),
            *(_in_query(name, meaning) for name, meaning in endpoint.query.items()),
        ],
        'responses': {
            '200': {'description': 'done', 'content': {endpoint.media: {}}},
            **{
                str(status): {'description': meaning, 'content': _PROBLEMS}
                for status, meaning in sorted(refusals.items())
            },
        },
    }
    if endpoint.method == 'POST':
        operation['requestBody'] = {'content': {'application/json': {'schema': _body(endpoint)}}}
    return operation


def _id(endpoint: Endpoint) -> str:
    words = re.findall(r'[a-z0-9]+', endpoint.path.removeprefix('/api'))
    return '_'.join([endpoint.method.lower(), *words])


def _in_path(name: str) -> dict[str, Any]:
    return {'name': name, 'in': 'path', 'required': True, 'schema': {'type': 'string'}}


def _in_query(name: str, meaning: str) -> dict[str, Any]:
    schema = {'type': 'string'}
    return {'name': name, 'in': 'query', 'description': meaning, 'schema': schema}


def _body(endpoint: Endpoint) -> Schema:
    return {
        'type': 'object',
        'properties': endpoint.body,
        'required': endpoint.required,
    }


_PROBLEM: Schema = {
    'type': 'object',
    'properties': {
        'message': {'type': 'string', 'description': 'what was expected, in words'},
        'said': {'type': 'object', 'description': 'the same by language, as far as it has it'},
    },
    'required': ['message', 'said'],
}
_PROBLEMS: Mapping[str, Any] = {
    'application/json': {'schema': {'$ref': '#/components/schemas/Problem'}}
}
