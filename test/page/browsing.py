"""What a person has in front of them: a browser, and tabs of the page in it."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

from browser import find_browser
from patience import PATIENCE_S
from playwright import sync_api
from playwright.sync_api import Browser, BrowserContext, Locator, Page, sync_playwright
from served_process import PASSWORD

_LOOK_MS, _MOMENT_MS = 20, 2000

_REFUSED = ', '.join(
    f'[data-answer="{kind}"]' for kind in ('refused', 'absent', 'unsent', 'login')
)

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

    @property
    def loaded(self) -> int:
        """How many times a tab was loaded."""
        return self.requested.count(f'{self.url}/')

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
        self._open: set[Any] = set()
        """Requests that have no answer yet."""
        page.on('request', self._on_request)
        for ended in ('requestfinished', 'requestfailed'):
            page.on(ended, self._on_answer)

    def go(self, screen: str) -> None:
        """Go to a screen, as a link there does, and wait until it is drawn."""
        self.page.evaluate('hash => { location.hash = hash }', f'#/{screen}')
        self.until_screen(screen)

    def until_screen(self, screen: str) -> None:
        """Wait until a screen is drawn."""
        name = screen.partition('/')[0]
        self.page.locator(f'main[data-screen="{name}"]').wait_for()

    def data(self, name: str) -> str:
        """Return what the page says of itself; see `static/core/store.js`."""
        value = self.page.evaluate('name => document.body.dataset[name] ?? ""', name)
        return str(value)

    def until_news(self, kind: str = 'fresh') -> None:
        """Wait until it says that its news are fresh, or that `page` or `node` is silent."""
        self.until(lambda: self.data('news') == kind, f'the news to be {kind}')

    @property
    def seq(self) -> int:
        """Last event that it shows."""
        return int(self.data('seq') or 0)

    @property
    def first(self) -> int:
        """Number of the first event that it was to take in."""
        return int(self.data('first'))

    @property
    def seen(self) -> list[int]:
        """Numbers of all events that it took in, in order."""
        missing = {
            number
            for span in self.data('gaps').split()
            for first, _, last in [span.partition('-')]
            for number in range(int(first), int(last) + 1)
        }
        return [n for n in range(self.first, self.seq + 1) if n not in missing]

    def until(
        self, condition: Callable[[], object], what: str, within_s: float = PATIENCE_S
    ) -> None:
        """Look at a condition until it holds; the page goes on meanwhile."""
        deadline = time.monotonic() + within_s
        while not condition():
            state = {name: self.data(name) for name in ('news', 'first', 'seq', 'gaps', 'twice')}
            assert time.monotonic() < deadline, f'waited {within_s:g} s for {what}; {state}'
            self.page.wait_for_timeout(_LOOK_MS)

    def log_in(self, name: str) -> None:
        """Log in by the menu in the corner, with the password of all."""
        self.page.locator('[data-menu="person"] > summary').click()
        self.page.locator('[data-menu="person"] [data-do="log-in"]').click()
        self.fill_login(name)

    def fill_login(self, name: str) -> None:
        """Say who it is, in the dialog that asks for it."""
        dialog = self.page.locator('dialog[data-dialog="login"]')
        dialog.locator('[name="username"]').fill(name)
        dialog.locator('[name="password"]').fill(PASSWORD)
        dialog.locator('[data-do="log-in"]').click()
        dialog.wait_for(state='detached')

    def answer(self, hold: str, answer: str, reason: str) -> None:
        """Answer a hold by the buttons of its card."""
        self.page.locator(f'[data-hold="{hold}"] [data-offer="hold.{answer}"]').click()
        self.confirm(f'hold.{answer}', reason)

    def confirm(self, request: str, reason: str) -> None:
        """Give the reason in the dialog of a request, and send it; it must be accepted."""
        dialog = self.page.locator(f'dialog[data-dialog="{request}"]')
        dialog.locator('[name="reason"]').fill(reason)
        held = dialog.locator('[data-hold-to-confirm]')
        answer = dialog.locator('.answer:visible')
        if held.count():
            deadline = time.monotonic() + PATIENCE_S
            while not answer.count() and dialog.count():
                assert time.monotonic() < deadline, f'no button of {request} can be held'
                self._hold_down(held)
        else:
            dialog.locator('[data-do="send"]').click()
        self.until(
            lambda: not dialog.count() or dialog.locator(_REFUSED).count(),
            f'the answer to {request}',
        )
        assert not dialog.count(), f'{request}: {dialog.inner_text()}'

    def _hold_down(self, button: Locator) -> None:
        """Hold a button until it lets go by itself, if that can be done now.

        It is disabled while the news are old, and goes with its dialog when the answer comes.
        """
        with suppress(sync_api.TimeoutError):
            button.click(trial=True, timeout=_MOMENT_MS)
            button.hover(timeout=_MOMENT_MS)
            self.page.mouse.down()
            self.until(lambda: not button.and_(self.page.locator('.is-held')).count(), 'its end')
            self.page.mouse.up()

    def until_quiet(self) -> None:
        """Wait until what the screen has asked for is there; its stream never ends."""
        self.until(lambda: not self._open, 'the answers of the page')
        self.page.evaluate('() => new Promise(requestAnimationFrame)')

    def too_wide(self) -> int:
        """Return by how many pixels the page is wider than its window."""
        wide = 'document.documentElement.scrollWidth - document.documentElement.clientWidth'
        return int(self.page.evaluate(wide))

    def _on_request(self, request: Any) -> None:
        if request.resource_type == 'fetch':
            self._open.add(request)

    def _on_answer(self, request: Any) -> None:
        self._open.discard(request)

    def count(self, selector: str) -> int:
        """Return how many elements there are."""
        return int(self.page.locator(selector).count())
