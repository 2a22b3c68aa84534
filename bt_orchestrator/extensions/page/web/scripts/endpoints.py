"""The routes of scripts and their drawings."""

from __future__ import annotations

from typing import Any

from starlette.requests import Request
from starlette.responses import Response

from bt_orchestrator.base.errors import JournalUnusable
from bt_orchestrator.extensions.page.web.endpoint import Endpoint
from bt_orchestrator.extensions.page.web.parts.tasks import TaskParts
from bt_orchestrator.extensions.page.web.replies import Json, Problem, language_of
from bt_orchestrator.extensions.page.web.scripts.drawing import Drawings
from bt_orchestrator.extensions.page.web.scripts.shelf import Shelf, parameters
from bt_orchestrator.extensions.page.web.seams import SeenCell
from bt_orchestrator.extensions.page.web.wording import wordings
from bt_orchestrator.model.jobs.isa95 import JobWord
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.status import (
    CellDescription,
    JobStatus,
    SectionStatus,
)
from bt_orchestrator.view.drawing.status_marks import NotThisLine

_UNKNOWN = {404: 'no script with this digest is known here', 503: 'the message says why not now'}


def endpoints(shelf: Shelf, cell: SeenCell) -> tuple[Endpoint, ...]:
    """Return the endpoints."""
    routes = _Routes(shelf, cell)
    return (
        Endpoint(
            'GET',
            '/api/scripts',
            routes.scripts,
            'returns the scripts that an order can name, with their parameters',
        ),
        Endpoint(
            'GET',
            '/api/recipes',
            routes.recipes,
            'returns the recipes that an order can name; of each version, the newest last, the '
            'parameters, and the operations that several components can do',
        ),
        Endpoint(
            'GET',
            '/api/scripts/{digest}',
            routes.script,
            'returns a script with the task lists of its sections',
            refusals=_UNKNOWN,
        ),
        Endpoint(
            'GET',
            '/api/drawing/{digest}.svg',
            routes.drawing,
            'returns the line of a script as a drawing',
            query={
                'live': '1: with the state of now',
                'language': f'of its words: {", ".join(wordings())}',
                'bare': '1: without title and legend',
            },
            refusals=_UNKNOWN,
            media='image/svg+xml',
        ),
    )


class _Routes:
    def __init__(self, shelf: Shelf, cell: SeenCell) -> None:
        self._shelf = shelf
        self._cell = cell
        self._drawings = Drawings()

    async def scripts(self, _: Request) -> Response:
        return Json(await self._shelf.listed())

    async def recipes(self, _: Request) -> Response:
        return Json(await self._shelf.recipes())

    async def script(self, request: Request) -> Response:
        digest = request.path_params['digest']
        return Json(_plain(digest, await self._script(digest), self._cell.description))

    async def drawing(self, request: Request) -> Response:
        digest = request.path_params['digest']
        script = await self._script(digest)
        cell = await self._shelf.cell()
        if cell is None:
            raise Problem(503, 'the node does not tell its cell now; a drawing needs it')
        status = self._cell.status if request.query_params.get('live') == '1' else None
        language = language_of(request, wordings(), 'en')
        try:
            is_bare = request.query_params.get('bare') == '1'
            drawn = await self._drawings.drawn(
                digest, script, cell, status, language, is_bare=is_bare
            )
        except NotThisLine as error:
            raise Problem(503, str(error)) from error
        headers = {'etag': drawn.tag, 'cache-control': 'no-cache'}
        if request.headers.get('if-none-match') == drawn.tag:
            return Response(status_code=304, headers=headers)
        return Response(drawn.svg, media_type='image/svg+xml', headers=headers)

    async def _script(self, digest: str) -> Script:
        try:
            script = await self._shelf.script(digest)
        except JournalUnusable as error:
            raise Problem(503, str(error)) from error
        if script is None:
            raise Problem(404, f'no script with the digest {digest} is known here')
        return script


def _plain(digest: str, script: Script, described: CellDescription | None) -> dict[str, Any]:
    tasks = TaskParts(described or CellDescription('', 0, ''), ())
    queued = JobStatus('', script.name, JobWord.ALLOWED_TO_START, position=1)
    return {
        'name': script.name,
        'digest': digest,
        'parameters': parameters(script.params.values()),
        'quantity': script.quantity,
        'source': script.source,
        'sink': script.sink,
        'sections': {
            str(number): tasks.of_section(SectionStatus(number), listed)
            for number, listed in script.sections.items()
        },
        'initialization': tasks.of_initialization(queued, script, ()),
    }
