"""The line of a script as SVG, with the state of now if it is asked for."""

from __future__ import annotations

import asyncio
import hashlib
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from bt_orchestrator.extensions.page.web.wording import wordings
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.view.drawing.line import draw_line
from bt_orchestrator.view.drawing.line_state import LineState
from bt_orchestrator.view.drawing.picture import SVG, Picture
from bt_orchestrator.view.drawing.status_marks import line_state

MOST_KEPT = 8
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
            if len(self._kept) > MOST_KEPT:
                self._kept.pop(next(iter(self._kept)))
        return known[2]


def _drawn(picture: Callable[[], Picture]) -> Drawn:
    svg = picture().content(SVG)
    return Drawn(svg, f'"{hashlib.sha256(svg).hexdigest()[:16]}"')
