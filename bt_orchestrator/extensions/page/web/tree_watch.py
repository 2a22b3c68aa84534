"""The behaviour tree, watched only while somebody looks at it."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable
from typing import Any

from starlette.requests import Request
from starlette.responses import Response

from bt_orchestrator.extensions.page.web.endpoint import Endpoint
from bt_orchestrator.extensions.page.web.replies import Json, Problem
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
        self._plain: dict[str, Any] | None = None
        self._come: asyncio.Event | None = None
        """None: closed."""
        self._watch: Watch | None = None
        """Belongs to the other thread."""
        self._closing: asyncio.TimerHandle | None = None

    @property
    def is_open(self) -> bool:
        """Tell whether the tree is watched."""
        return self._come is not None

    async def newest(self, after: int) -> dict[str, Any] | None:
        """Return the tree, opening the watch; None: the node does not tell it.

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
        return {
            'version': self._version,
            'tree': None if after == self._version else self._plain,
        }

    def close(self) -> None:
        """Stop watching."""
        if self._closing is not None:
            self._closing.cancel()
        self._closing = self._come = self._plain = None
        self._do(self.leave)

    # --- in the loop ------------------------------------------------------------------------

    def _open(self) -> None:
        loop, come = asyncio.get_running_loop(), asyncio.Event()
        self._come = come

        def take(plain: dict[str, Any]) -> None:
            if self._come is come:
                self._version += 1
                self._plain = plain
                come.set()

        def hear(tree: Branch) -> None:
            with contextlib.suppress(RuntimeError):  # the loop has ended
                loop.call_soon_threadsafe(take, plain_branch(tree))

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


def plain_branch(branch: Branch) -> dict[str, Any]:
    """Return a tree as JSON carries it."""
    return {
        'name': branch.name,
        'status': branch.status.word,
        'message': branch.words,
        'is_decorator': branch.is_decorator,
        'children': list(map(plain_branch, branch.children)),
    }


def endpoints(watch: TreeWatch) -> tuple[Endpoint, ...]:
    """Return the endpoint of the tree."""

    async def tree(request: Request) -> Response:
        after = request.query_params.get('after', '0')
        if not (after.isascii() and after.isdecimal()):
            raise Problem(422, f'after is the version that you have; found {after!r}')
        found = await watch.newest(int(after))
        if found is None:
            raise Problem(503, 'the node does not tell its behaviour tree now')
        return Json(found)

    return (
        Endpoint(
            'GET',
            '/api/tree',
            tree,
            'returns the behaviour tree; ask once a second, and it is watched meanwhile',
            query={'after': 'version that you have: without a change the tree is null'},
            refusals={503: 'the node does not tell it now'},
        ),
    )
