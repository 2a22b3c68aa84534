"""The web application: all routes of the page, and what stands before them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import FileResponse, JSONResponse, Response
from starlette.routing import BaseRoute, Mount, Route
from starlette.staticfiles import StaticFiles

from bt_orchestrator.extensions.page.web import (
    account,
    archive,
    cells,
    commands,
    me,
    scripts,
    tree_watch,
)
from bt_orchestrator.extensions.page.web.endpoint import Endpoint, routes
from bt_orchestrator.extensions.page.web.guards import GuardMiddleware
from bt_orchestrator.extensions.page.web.openapi import with_description
from bt_orchestrator.extensions.page.web.planning import endpoints as planning
from bt_orchestrator.extensions.page.web.planning.page_queue import PageQueue
from bt_orchestrator.extensions.page.web.replies import HANDLERS, Json, Problem
from bt_orchestrator.model.codec import to_plain

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
        *cells.endpoints(page.sources.cells),
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
        Endpoint('GET', '/healthz', healthz, 'the page is there, and how long the node is silent'),
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
