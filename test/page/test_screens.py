"""Every screen: without barriers, without overflow, by keyboard, and from the page alone."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from datetime import datetime
from pathlib import Path
from typing import Any

import pytest
from page.axe import barriers
from page.browsing import Person, Tab
from page.conftest import Sit
from page.stands import Stand, stand

from bt_orchestrator.store.memory import MemoryRecords, MemoryStore
from bt_orchestrator.view.report.account.account import account
from bt_orchestrator.view.report.account.period import Period
from bt_orchestrator.view.report.account.words import percent
from bt_orchestrator.view.report.reading import Reading

SCREENS = (
    'overview',
    'queue',
    'order',
    'section/2',
    'component/component_2a',
    'why',
    'alarms',
    'shift',
    'tree',
    'jobs',
    'job/WO-1001',
    'item/WO-1001/1',
    'cells',
)
SIZES = ((1920, 1080), (1280, 800), (768, 1024), (390, 844))
LOOKS = [(theme, language) for theme in ('light', 'dark') for language in ('en-GB', 'de-DE')]


@pytest.fixture(scope='module')
def held(tmp_path_factory: pytest.TempPathFactory, browser: Any) -> Iterator[Stand]:
    """Give a line that is Held, with something behind it and something to come."""
    with stand(tmp_path_factory.mktemp('stand')) as line:
        person = Person(browser, f'http://127.0.0.1:{line.port}')
        tab = person.open()
        tab.until(lambda: tab.count('[data-hold]'), 'a hold')
        person.leave()
        yield line


@pytest.mark.parametrize(('theme', 'language'), LOOKS)
def test_no_screen_has_a_barrier(held: Stand, sit: Sit, theme: str, language: str) -> None:
    tab = sit(held.port, color_scheme=theme, locale=language).open()
    tab.until_news()
    assert tab.page.locator('html').get_attribute('lang') == language[:2]
    obstacles = {screen: obstacles for screen in SCREENS if (obstacles := found_on(tab, screen))}
    tab.go('overview')
    tab.page.locator('[data-hold] [data-offer]').first.click()
    tab.page.locator('dialog [data-do="leave"]').wait_for()
    if in_dialog := barriers(tab):
        obstacles['dialog'] = in_dialog
    assert not obstacles


def test_the_overview_shows_the_figures_of_the_report(held: Stand, sit: Sit) -> None:
    tab = sit(held.port).open()
    shown: dict[str, str] = {}

    def are_those_of_the_report() -> bool:
        """The shift goes on: compare with a report of the moment of which the page tells."""
        shift = tab.page.evaluate('() => fetch("/api/shift").then((answer) => answer.json())')
        begin, end = (round(at(shift['period'][name]) * 1e6) for name in ('from', 'to'))
        with held.cell.lock:
            assert isinstance(held.cell.store, MemoryStore)
            reading = Reading(MemoryRecords(held.cell.store))
            made = account(reading, Period.all_planned('', begin, end), held.cell.cell).figures
        names = ('oee', 'availability', 'performance', 'quality')
        for name in names:
            shown[name] = tab.page.locator(f'[data-figure="{name}"]').inner_text()
        assert made.oee is not None
        return shown == {name: percent(getattr(made, name)) for name in names}

    tab.until(lambda: tab.count('[data-part="shift"][data-runs]'), 'the shift')
    tab.until(are_those_of_the_report, 'the figures of the report')
    assert shown['oee'] not in ('', '-', '0.0 %')
    assert tab.count('[data-part="shift"] [data-loss]') > 1
    files = tab.page.locator('[data-part="shift"] a[download]')
    with tab.page.expect_download() as download:
        files.first.click()
    assert download.value.suggested_filename.startswith('shift-early-of-')
    with tab.page.expect_download() as download:
        files.last.click()
    text = Path(download.value.path()).read_text(encoding='utf-8')
    assert ('<h2>Side by side</h2>' in text, 'Largest losses' in text) == (True, True)


def at(moment: str) -> float:
    return datetime.fromisoformat(moment).timestamp()


def test_barriers_and_what_is_too_wide_are_found(held: Stand, sit: Sit) -> None:
    tab = sit(held.port).open()
    assert (barriers(tab), tab.too_wide()) == ([], 0)
    tab.page.evaluate('document.querySelector("main").append(document.createElement("button"))')
    assert 'button-name' in barriers(tab)[0]
    tab.page.evaluate('document.querySelector("main").lastChild.style.width = "5000px"')
    assert tab.too_wide() > 0


def found_on(tab: Tab, screen: str) -> list[str]:
    tab.go(screen)
    tab.until_quiet()
    return barriers(tab)


def test_the_dialog_to_log_in_has_no_barrier(tmp_path: Path, sit: Sit) -> None:
    with stand(tmp_path, login=True) as line:
        for theme, language in LOOKS:
            tab = sit(line.port, color_scheme=theme, locale=language).open('login')
            assert not barriers(tab)
            tab.page.locator('main [data-do="log-in"]').click()
            tab.page.locator('dialog[data-dialog="login"]').wait_for()
            assert not barriers(tab)


@pytest.mark.parametrize('sections', [5, 20, 100])
def test_no_line_is_wider_than_the_window(tmp_path: Path, sit: Sit, sections: int) -> None:
    with stand(tmp_path, sections=sections) as line:
        person = sit(line.port)
        tab = person.open()
        tab.until(lambda: tab.count('[data-section]') == sections, 'all sections')
        screens = (
            'overview',
            'queue',
            'order',
            f'section/{sections}',
            'why',
            'tree',
            'jobs',
            'cells',
        )
        too_wide = {}
        for width, height in SIZES:
            tab.page.set_viewport_size({'width': width, 'height': height})
            for screen in screens:
                tab.go(screen)
                tab.until_quiet()
                if wide := tab.too_wide():
                    too_wide[width, screen] = wide
        assert not too_wide


def test_the_browser_calls_the_page_alone(held: Stand, sit: Sit) -> None:
    person = sit(held.port)
    tab = person.open()
    for screen in SCREENS:
        tab.go(screen)
        tab.until_quiet()
    others = [url for url in person.requested if not url.startswith(f'{person.url}/')]
    assert person.requested
    assert not others


def test_shift_detail_matches_report(tmp_path: Path, sit: Sit) -> None:
    """A task that failed once, and was answered: its cause, and the figures by owner."""
    with stand(tmp_path, speed=20.0) as line:
        tab = sit(line.port).open()
        tab.until(lambda: tab.count('[data-hold]'), 'a hold')
        hold = next(iter(line.happened('hold.raised')))['hold']
        line.ask('hold.retry', hold=hold)
        tab.until(lambda: tab.count('[data-part="shift"][data-runs]'), 'the shift')
        tab.page.locator('[data-part="shift"] a[href="#/shift"]').click()
        content = tab.page.locator('main')

        def says(words: str) -> Callable[[], bool]:
            return lambda: words in content.inner_text()

        tab.until(says('further attempt'), 'the cause of the further attempt')
        tab.until(says('own fault: fault'), 'the part of the loss')
        tab.page.locator('main select').select_option('component')
        tab.until(says('operating time'), 'the figures of components')
        tab.until(says('component_3a'), 'a component')
        if 'SHIFT_PICTURES' in os.environ:
            tab.page.screenshot(path=f'{os.environ["SHIFT_PICTURES"]}/detail.png', full_page=True)
