"""Fixtures of the page's tests: a cell, its page, a wire that can be cut, and a browser."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from cell_fixtures import fast_discovery, loaded, start_cell
from page.browsing import Person, chromium
from page.proxy import Proxy
from page_process import PageProcess

__all__ = ['fast_discovery', 'loaded', 'start_cell']

StartPage = Callable[..., PageProcess]
"""Starts the page of a node and waits until it serves; takes options of the verb."""

StartProxy = Callable[[int], Proxy]
"""Lays a wire to a port."""

Sit = Callable[..., Person]
"""Seats somebody at a browser; takes the port of the page, or of a wire to it."""


@pytest.fixture(scope='session')
def browser() -> Iterator[Any]:
    """Give the one browser of all tests."""
    with chromium() as instance:
        yield instance


@pytest.fixture
def start_page(tmp_path: Path) -> Iterator[StartPage]:
    """Give a function that starts a page."""
    with ExitStack() as stack:

        def start(*options: str, node: str = '/bt_orchestrator') -> PageProcess:
            page = PageProcess(tmp_path, node, options)
            stack.callback(page.close)
            page.wait_ready()
            return page

        yield start


@pytest.fixture
def start_proxy() -> Iterator[StartProxy]:
    """Give a function that lays a wire to a port."""
    with ExitStack() as stack:

        def start(port: int) -> Proxy:
            proxy = Proxy(port)
            stack.callback(proxy.close)
            return proxy

        yield start


@pytest.fixture
def sit(browser: Any) -> Iterator[Sit]:
    """Give a function that seats somebody."""
    people: list[Person] = []

    def down(port: int, **settings: Any) -> Person:
        people.append(Person(browser, f'http://127.0.0.1:{port}', **settings))
        return people[-1]

    yield down
    for person in people:
        person.leave()
