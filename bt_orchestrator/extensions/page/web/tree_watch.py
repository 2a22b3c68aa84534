"""The behaviour tree, watched only while somebody looks at it."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable
from functools import partial
from typing import Any

from starlette.requests import Request
from starlette.responses import Response

from bt_orchestrator.extensions.page.web.endpoint import Endpoint, Json, Problem, language_of
from bt_orchestrator.extensions.page.web.parts.tasks import waits_said
from bt_orchestrator.extensions.page.web.seams import SeenCell
from bt_orchestrator.extensions.page.web.wording import wordings
from bt_orchestrator.model.branch import Branch
from bt_orchestrator.ports import CellLink, Watch

KEPT_OPEN_S = 10.0
"""So long after the last look the watch is closed."""

FIRST_WITHIN_S = 5.0
"""Longest wait for the first tree."""

Do = Callable[[Callable[[CellLink], object]], None]
"""Has something done by the thread that follows the cell, between two turns of its door."""


class TreeWatch:
    """States: closed, open. All calls come from the loop's thread."""

    def __init__(self, do: Do) -> None:
        self._do = do
        self._version = 0
        """Counts the trees that were heard."""
        self._tree: Branch | None = None
        self._come: asyncio.Event | None = None
        """None: closed."""
        self._watch: Watch | None = None
        """Belongs to the other thread."""
        self._closing: asyncio.TimerHandle | None = None

    @property
    def is_open(self) -> bool:
        """Tell whether the tree is watched."""
        return self._come is not None

    async def newest(self, after: int) -> tuple[int, Branch | None] | None:
        """Return version and tree, opening the watch; None: the node does not tell it.

        :param after: version that the reader has; then the tree is left out if it is the newest
        """
        if self._come is None:
            self._open()
        assert self._come is not None
        self._close_later()
        try:
            await asyncio.wait_for(self._come.wait(), FIRST_WITHIN_S)
        except (TimeoutError, asyncio.TimeoutError):
            return None
        return self._version, None if after == self._version else self._tree

    def close(self) -> None:
        """Stop watching."""
        if self._closing is not None:
            self._closing.cancel()
        self._closing = self._come = self._tree = None
        self._do(self.leave)

    # --- in the loop ------------------------------------------------------------------------

    def _open(self) -> None:
        loop, come = asyncio.get_running_loop(), asyncio.Event()
        self._come = come

        def take(tree: Branch) -> None:
            if self._come is come:
                self._version += 1
                self._tree = tree
                come.set()

        def hear(tree: Branch) -> None:
            with contextlib.suppress(RuntimeError):  # the loop has ended
                loop.call_soon_threadsafe(take, tree)

        def begin(door: CellLink) -> None:
            self.leave(door)
            self._watch = door.watch_tree(hear)

        self._do(begin)

    def _close_later(self) -> None:
        if self._closing is not None:
            self._closing.cancel()
        self._closing = asyncio.get_running_loop().call_later(KEPT_OPEN_S, self.close)

    # --- in the thread that follows ---------------------------------------------------------

    def leave(self, _: CellLink) -> None:
        """Watch nothing through this door any more."""
        if self._watch is not None:
            self._watch.close()
            self._watch = None


Say = Callable[[str], str]


def plain_branch(branch: Branch, name: Say = str, message: Say = str) -> dict[str, Any]:
    """Return a tree as JSON carries it.

    :param name: says the name of a behaviour; `message`: its message
    """
    return {
        'name': name(branch.name),
        'status': branch.status.word,
        'message': message(branch.words),
        'is_decorator': branch.is_decorator,
        'children': [plain_branch(child, name, message) for child in branch.children],
    }


def endpoints(watch: TreeWatch, cell: SeenCell) -> tuple[Endpoint, ...]:
    """Return the endpoint of the tree."""

    async def tree(request: Request) -> Response:
        after = request.query_params.get('after', '0')
        if not (after.isascii() and after.isdecimal()):
            raise Problem(422, f'after is the version that you have; found {after!r}')
        language = language_of(request, wordings(), '')
        update = await watch.newest(int(after))
        if update is None:
            raise Problem(503, 'the node does not tell its behaviour tree now')
        version, newest = update
        return Json({'version': version, 'tree': newest and _said(newest, language)})

    def _said(newest: Branch, language: str) -> dict[str, Any]:
        if not language:
            return plain_branch(newest)
        words = wordings()[language]
        waits = waits_said(cell.status, language) if cell.status else {}
        return plain_branch(newest, words.twig, partial(words.twig_message, waits=waits))

    return (
        Endpoint(
            'GET',
            '/api/tree',
            tree,
            'returns the behaviour tree; ask once a second, and it is watched meanwhile',
            query={
                'after': 'version that you have: without a change the tree is null',
                'language': f'of its words, as the page says them: {", ".join(wordings())}; '
                'without it they are those of the node',
            },
            refusals={503: 'the node does not tell it now'},
        ),
    )
