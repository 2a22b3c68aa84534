"""What a person has in front of them: a browser, and tabs of the page in it."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from browser import find_browser
from playwright.sync_api import Browser, BrowserContext, Page, sync_playwright

PATIENCE_S = 60.0
_LOOK_MS = 20

_WRONG = ('Content Security Policy', 'Uncaught')
"""What the console must not say; that a connection is gone, it may."""


@contextmanager
def chromium() -> Iterator[Browser]:
    """Run a browser without a window."""
    # Chromium refuses its own sandbox to root, as whom containers run.
    options = ['--no-sandbox'] if os.geteuid() == 0 else []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=find_browser(), args=options)
        try:
            yield browser
        finally:
            browser.close()


class Person:
    """Somebody at a browser: cookies of their own, and tabs that share a worker."""

    def __init__(self, browser: Browser, url: str, **settings: Any) -> None:
        """Sit down.

        :param url: of the page
        :param settings: of the browser, such as `viewport`, `color_scheme` and `locale`
        """
        self.url = url
        settings = {'locale': 'en-GB', 'timezone_id': 'Europe/Berlin', **settings}
        self.context: BrowserContext = browser.new_context(**settings)
        self.context.set_default_timeout(PATIENCE_S * 1e3)
        self.requested: list[str] = []
        """Addresses that the browser has asked for, those of workers too."""
        self.wrong: list[str] = []
        """What went wrong in scripts, and what the page's own policy forbids."""
        self.context.on('request', lambda request: self.requested.append(request.url))
        self.context.on('console', self._on_console)
        self.context.on('weberror', lambda error: self.wrong.append(str(error.error)))

    def open(self, screen: str = 'overview') -> Tab:
        """Open a tab at a screen, and wait until it is drawn."""
        tab = Tab(self.context.new_page(), self.url)
        tab.page.goto(f'{self.url}/#/{screen}')
        tab.until_screen(screen)
        return tab

    def leave(self) -> None:
        """Close everything, and fail if something went wrong meanwhile."""
        self.context.close()
        assert not self.wrong, self.wrong

    def _on_console(self, message: Any) -> None:
        if message.type == 'error' and any(word in message.text for word in _WRONG):
            self.wrong.append(message.text)


class Tab:
    """A tab with the page.

    :ivar page: for what is not here
    """

    def __init__(self, page: Page, url: str) -> None:
        self.page = page
        self._url = url

    def go(self, screen: str) -> None:
        """Go to a screen, as a link there does, and wait until it is drawn."""
        self.page.evaluate('hash => { location.hash = hash }', f'#/{screen}')
        self.until_screen(screen)

    def until_screen(self, screen: str) -> None:
        """Wait until a screen is drawn."""
        name = screen.partition('/')[0]
        self.until(lambda: self.data('screen') == name, f'the screen {name}')

    def data(self, name: str) -> str:
        """Return what the page says of itself, for tests; see `static/core/store.js`."""
        found = self.page.evaluate('name => document.body.dataset[name] ?? ""', name)
        return str(found)

    def until_live(self) -> None:
        """Wait until it shows what happens."""
        self.until_state('live')

    def until_state(self, state: str) -> None:
        """Wait until it says that it is live, or what is silent."""
        self.until(lambda: self.data('state') == state, f'the page to be {state}')

    @property
    def seq(self) -> int:
        """Last event that it shows."""
        return int(self.data('seq') or 0)

    @property
    def seen(self) -> list[int]:
        """Every event that it took in, in order."""
        return numbers(self.data('seen'))

    def until(
        self, condition: Callable[[], object], what: str, within_s: float = PATIENCE_S
    ) -> None:
        """Look at a condition until it holds; the page goes on meanwhile."""
        deadline = time.monotonic() + within_s
        while not condition():
            state = {name: self.data(name) for name in ('screen', 'state', 'seq', 'seen')}
            assert time.monotonic() < deadline, f'waited {within_s:g} s for {what}; {state}'
            self.page.wait_for_timeout(_LOOK_MS)

    def count(self, selector: str) -> int:
        """Return how many elements there are."""
        return int(self.page.locator(selector).count())


def numbers(ranges: str) -> list[int]:
    """Return the numbers of ranges such as `1-3,5`."""
    found: list[int] = []
    for part in filter(None, ranges.split(',')):
        first, _, last = part.partition('-')
        found += range(int(first), int(last or first) + 1)
    return found
