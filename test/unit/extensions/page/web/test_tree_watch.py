"""The behaviour tree is watched while somebody looks, and not a moment longer than ten seconds."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from functools import partial
from typing import Any, cast

import pytest

from bt_orchestrator.extensions.page.web import tree_watch
from bt_orchestrator.extensions.page.web.tree_watch import TreeWatch, plain_branch
from bt_orchestrator.extensions.page.web.wording import wordings
from bt_orchestrator.model.branch import Branch, Outcome
from bt_orchestrator.ports import CellLink

LEAF = Branch('TASK_A', Outcome.RUNNING, 'running at /a', is_decorator=False, children=())
ROOT = Branch('CELL', Outcome.RUNNING, '', is_decorator=False, children=(LEAF,))


class Door:
    """Says what is watched."""

    def __init__(self) -> None:
        self.hear: Callable[[Branch], None] | None = None
        self.opened = 0

    def do(self, work: Callable[[CellLink], object]) -> None:
        work(cast('CellLink', cast('Any', self)))

    def watch_tree(self, hear: Callable[[Branch], None]) -> Door:
        self.hear = hear
        self.opened += 1
        hear(ROOT)
        return self

    def close(self) -> None:
        self.hear = None


def test_a_tree_as_json() -> None:
    assert plain_branch(ROOT) == {
        'name': 'CELL',
        'status': 'running',
        'message': '',
        'is_decorator': False,
        'children': [
            {
                'name': 'TASK_A',
                'status': 'running',
                'message': 'running at /a',
                'is_decorator': False,
                'children': [],
            }
        ],
    }


def test_a_tree_in_the_words_of_a_language() -> None:
    german = wordings()['de']
    message = partial(german.twig_message, waits={'waiting for a; b': 'wartet auf a; b'})
    branch = plain_branch(
        Branch('retry up to 1 time', Outcome.RUNNING, 'waiting for a; b', True, (LEAF,)),
        german.twig,
        message,
    )
    assert (branch['name'], branch['message']) == ('bis zu 1 neuer Versuch', 'wartet auf a; b')
    (leaf,) = branch['children']
    assert (leaf['name'], leaf['message']) == ('TASK_A', 'läuft bei /a')


def test_first_look_opens_watch_that_others_reuse() -> None:
    async def look() -> None:
        door = Door()
        watch = TreeWatch(door.do)
        assert door.opened == 0
        first = await watch.newest(0)
        assert first == (1, ROOT)
        assert await watch.newest(1) == (1, None)
        assert door.hear is not None
        door.hear(LEAF)
        await asyncio.sleep(0)
        assert await watch.newest(1) == (2, LEAF)
        assert door.opened == 1
        watch.close()

    asyncio.run(look())


def test_watch_closes_some_time_after_last_look(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(tree_watch, 'KEPT_OPEN_S', 0.0)

    async def look() -> None:
        door = Door()
        watch = TreeWatch(door.do)
        await watch.newest(0)
        while watch.is_open:
            await asyncio.sleep(0.001)
        assert door.hear is None
        monkeypatch.setattr(tree_watch, 'KEPT_OPEN_S', 10.0)
        again = await watch.newest(0)
        assert again is not None
        assert again[0] == 2, 'a reader of before is not told that nothing has changed'
        watch.close()

    asyncio.run(asyncio.wait_for(look(), 10.0))


def test_a_node_that_tells_no_tree(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tree_watch, 'FIRST_WITHIN_S', 0.01)

    async def look() -> None:
        watch = TreeWatch(lambda _: None)
        assert await watch.newest(0) is None
        watch.close()

    asyncio.run(look())
