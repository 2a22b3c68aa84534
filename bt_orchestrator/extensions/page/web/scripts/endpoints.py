"""The routes of scripts and their drawings."""

from __future__ import annotations

import asyncio
import hashlib
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

from starlette.requests import Request
from starlette.responses import Response

from bt_orchestrator.base.errors import JournalUnusable
from bt_orchestrator.extensions.page.web.endpoint import Endpoint, Json, Problem, language_of
from bt_orchestrator.extensions.page.web.parts.tasks import TaskParts
from bt_orchestrator.extensions.page.web.scripts.shelf import Shelf, parameters
from bt_orchestrator.extensions.page.web.seams import SeenCell
from bt_orchestrator.extensions.page.web.wording import wordings
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.jobs.isa95 import JobWord
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.status import CellDescription, CellStatus, JobStatus, SectionStatus
from bt_orchestrator.view.drawing.line import draw_line
from bt_orchestrator.view.drawing.line_state import LineState
from bt_orchestrator.view.drawing.picture import SVG, Picture
from bt_orchestrator.view.drawing.status_marks import NotThisLine, line_state

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


# The line of a script as SVG, with the state of now if it is asked for.

MOST_DRAWINGS_KEPT = 8
"""Drawings that need not be made again: of some scripts, plain and live."""


class Drawn(NamedTuple):
    """A drawing, and its name in the caches of browsers."""

    svg: bytes
    tag: str


class Drawings:
    """Draws in another thread, one after the other, and only what has changed."""

    def __init__(self) -> None:
        self._kept: dict[tuple[str, bool, str, bool], tuple[Cell, LineState | None, Drawn]] = {}
        self._turn = asyncio.Lock()

    async def drawn(
        self,
        digest: str,
        script: Script,
        cell: Cell,
        status: CellStatus | None,
        language: str = 'en',
        *,
        is_bare: bool = False,
    ) -> Drawn:
        """Return the drawing of a script.

        :param status: as the line stands; None: the script alone
        :param language: one of `wordings`
        :param is_bare: without title and legend
        :raises NotThisLine: the status is of another cell
        """
        words = wordings()[language]
        state = None if status is None else line_state(status, script, cell, words)
        key = (digest, status is not None, language, is_bare)
        async with self._turn:
            known = self._kept.pop(key, None)
            if known is None or known[:2] != (cell, state):
                picture = partial(draw_line, script, cell, state, words, is_bare=is_bare)
                known = (cell, state, await asyncio.to_thread(_drawn, picture))
            self._kept[key] = known
            if len(self._kept) > MOST_DRAWINGS_KEPT:
                self._kept.pop(next(iter(self._kept)))
        return known[2]


def _drawn(picture: Callable[[], Picture]) -> Drawn:
    svg = picture().content(SVG)
    return Drawn(svg, f'"{hashlib.sha256(svg).hexdigest()[:16]}"')
