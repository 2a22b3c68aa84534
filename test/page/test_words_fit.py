"""Words have room: none is broken inside, and what the top bar says is not cut."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from page.browsing import Person, Tab
from page.conftest import Sit
from page.stands import Stand, stand

SCREENS = (
    'overview',
    'queue',
    'order',
    'why',
    'alarms',
    'shift',
    'section/4',
    'tree',
    'jobs',
    'item/WO-1001/1',
)
SIZES = ((1920, 1080), (1366, 768), (768, 1024), (390, 844))
PHONE = {'width': 390, 'height': 844}
MOST_LETTERS = 12
"""Longer words, as names may be, are broken where there is no room."""

_BROKEN = """
most => {
  const found = [];
  const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (texts.nextNode()) {
    const node = texts.currentNode;
    if (!node.parentElement.checkVisibility({ visibilityProperty: true })) continue;
    if (node.parentElement.closest('.for-readers')) continue;
    for (const word of node.data.matchAll(/[^\\s\\/-]+/g)) {
      if (word[0].length > most) continue;
      const range = document.createRange();
      range.setStart(node, word.index);
      range.setEnd(node, word.index + word[0].length);
      const lines = new Set([...range.getClientRects()].map((one) => Math.round(one.top)));
      if (lines.size > 1) found.push(word[0]);
    }
  }
  return found;
}
"""

WHOLE = (
    *('.cell-name', '.state-word', '.state-since', 'nav a', '.person-words'),
    *(
        '.section-wait:not([data-ordinary])',
        '.hold-message',
        '.job-link',
        '.job-script',
        '.job-preparing',
    ),
    *('.job-name', '.what-if table'),
)
"""What is never cut, in width or height."""

_SCROLLED = '() => { scrollTo(0, 300); return scrollY; }'

_CUT = """
names => [...document.querySelectorAll(names)]
  .filter((one) => one.clientWidth > 0 && one.checkVisibility()
    && (one.scrollWidth > one.clientWidth + 1 || one.scrollHeight > one.clientHeight + 2)
    || one.getBoundingClientRect().right > innerWidth)
  .map((one) => `${one.className}: ${one.textContent}`)
"""


_OUTSIDE = """
() => [...document.querySelectorAll('body *')]
  .filter((one) => one.checkVisibility({ visibilityProperty: true })
    && !one.closest('.for-readers, .picture-room, .tree')
    && one.getBoundingClientRect().right > document.documentElement.clientWidth + 1)
  .map((one) => `${one.tagName}.${one.className}: ${one.textContent.slice(0, 40)}`)
"""

_PLACES = """
() => [...document.querySelectorAll('.section-card, main > * > *')]
  .map((one) => one.getBoundingClientRect().top)
"""


@pytest.fixture(scope='module')
def held(tmp_path_factory: pytest.TempPathFactory, browser: Any) -> Iterator[Stand]:
    """Give a line that is Held, and a component out of service that jobs in the queue need."""
    with stand(tmp_path_factory.mktemp('stand')) as line:
        person = Person(browser, f'http://127.0.0.1:{line.port}')
        tab = person.open()
        tab.until(lambda: tab.count('[data-hold]'), 'a hold')
        line.ask('component.out_of_service', component='component_3b')
        tab.until(lambda: tab.count('[data-component="component_3b"]'), 'what is out of service')
        person.leave()
        yield line


@pytest.mark.parametrize('language', ['en-GB', 'de-DE'])
def test_words_are_unbroken_and_top_bar_whole(held: Stand, sit: Sit, language: str) -> None:
    tab = sit(held.port, locale=language).open()
    tab.until_news()
    defects = {}
    for width, height in SIZES:
        tab.page.set_viewport_size({'width': width, 'height': height})
        for screen in SCREENS:
            tab.go(screen)
            tab.until_quiet()
            if wrong := broken(tab) + cut(tab) + outside(tab):
                defects[width, screen] = wrong
    assert not defects


@pytest.mark.parametrize('language', ['en-GB', 'de-DE'])
def test_long_reason_keeps_layout_and_stays_readable(
    tmp_path: Path, sit: Sit, language: str
) -> None:
    reason = 'somebody reached into station 4 because a part had fallen between belt and guide'
    with stand(tmp_path, fail=['none']) as line:
        tab = sit(line.port, locale=language).open()
        tab.until_news()
        before = {size: height_of_the_bar(tab, size) for size in SIZES}
        line.ask('cell.abort', reason=f'{reason}; {reason.replace("4", "5")}')
        why = tab.page.locator('.state-why')
        tab.until(lambda: reason in (why.text_content() or ''), 'the reason')
        assert {size: height_of_the_bar(tab, size) for size in SIZES} == before
        defects = {}
        for width, height in SIZES:
            tab.page.set_viewport_size({'width': width, 'height': height})
            why.evaluate('one => one.blur()')
            tab.page.mouse.move(0, height - 1)
            tab.until_quiet()
            if why.get_attribute('data-cut') is not None:
                why.focus()
            if (
                wrong := broken(tab)
                + outside(tab)
                + tab.page.evaluate(_CUT, '.state-why .room-words')
            ):
                defects[width] = wrong
        assert not defects
        assert why.get_attribute('data-cut') is not None, 'a telephone has no room for it'


def height_of_the_bar(tab: Tab, size: tuple[int, int]) -> float:
    """Return it in a window, in pixels."""
    tab.page.set_viewport_size({'width': size[0], 'height': size[1]})
    tab.until_quiet()
    height = tab.page.evaluate("document.getElementById('top').getBoundingClientRect().height")
    return float(height)


def test_wait_too_long_for_card_is_readable(held: Stand, sit: Sit) -> None:
    tab = sit(held.port, locale='de-DE', viewport={'width': 1366, 'height': 768}).open()
    tab.until_news()
    wait = tab.page.locator('[data-section="1"] .section-wait').last
    below = tab.page.evaluate(_PLACES)
    long = 'wartet auf Station 2, Station 3, Station 4, 12 weitere; ' * 3
    wait.evaluate(
        """(one, words) => {
          one.dataset.ordinary = '';
          one.firstChild.textContent = words;
        }""",
        long,
    )
    tab.until(lambda: wait.get_attribute('data-cut') is not None, 'the sign that it is cut')
    wait.hover()
    words = wait.locator('.room-words')
    assert words.evaluate('one => one.scrollHeight <= one.clientHeight + 1')
    assert tab.page.evaluate(_PLACES) == below, 'nothing has moved'


def test_reason_replaces_table_when_end_is_unknown(held: Stand, sit: Sit) -> None:
    tab = sit(held.port, locale='de-DE', viewport=PHONE).open('queue')
    tab.until_news()
    tab.page.locator('[data-job="WO-1003"] [data-offer="job.next"]').click()
    tab.page.locator('dialog [data-what-if="known"]').wait_for()
    (why,) = tab.page.locator('dialog .what-if-why').all_inner_texts()
    assert 'WO-1003' in why
    assert 'Wartet auf eine Antwort: Station 4, mark, component_3a' in why
    assert not tab.count('dialog [data-what-if] table')
    assert not broken(tab)
    assert tab.too_wide() == 0


def test_table_of_expected_ends_fits_telephone(tmp_path: Path, sit: Sit) -> None:
    with stand(tmp_path, fail=['none'], speed=0.2) as line:
        line.ask('component.out_of_service', component='component_3b')
        line.ask('component.in_service', component='component_3b')
        tab = sit(line.port, locale='de-DE', viewport=PHONE).open('queue')
        tab.until_news()
        tab.page.locator('[data-job="WO-1003"] [data-offer="job.next"]').click()
        tab.until(lambda: tab.count('dialog [data-what-if] table'), 'the table')
        assert (broken(tab), cut(tab)) == ([], [])


def test_reasons_for_unknown_ends_are_german(tmp_path: Path, sit: Sit) -> None:
    with stand(tmp_path, fail=['none'], speed=0.2) as line:
        line.ask('job.hold', job='WO-1004')
        line.ask('component.out_of_service', component='component_3b')
        tab = sit(line.port, locale='de-DE').open('queue')
        tab.until_news()
        tab.page.locator('[data-job="WO-1003"] [data-offer="job.next"]').click()
        tab.page.locator('dialog [data-what-if="known"]').wait_for()
        reasons = ' '.join(tab.page.locator('dialog .what-if-why').all_inner_texts())
        assert 'WO-1003 braucht component_3b, außer Betrieb' in reasons
        assert 'WO-1004 ist in der Warteschlange zurückgehalten; WO-1004 braucht' in reasons
        assert 'needs' not in reasons


def test_broken_word_and_cut_name_are_detected(held: Stand, sit: Sit) -> None:
    tab = sit(held.port).open()
    tab.until_news()
    assert (broken(tab), cut(tab)) == ([], [])
    tab.page.evaluate("""() => {
      document.querySelector('main h2').style.width = '1px';
      document.querySelector('.cell-name').style.width = '10px';
    }""")
    assert broken(tab)
    assert cut(tab) == [f'cell-name: {held.cell.cell.name}']


def test_each_screen_begins_at_its_top(held: Stand, sit: Sit) -> None:
    tab = sit(held.port, viewport={'width': 390, 'height': 600}).open()
    for screen in ('queue', 'jobs', 'overview'):
        tab.until(lambda: tab.page.evaluate(_SCROLLED), 'the page to be scrolled')
        tab.go(screen)
        tab.until_quiet()
        assert tab.page.evaluate('scrollY') == 0


def test_nothing_is_claimed_of_what_is_not_known(held: Stand, sit: Sit) -> None:
    tab = sit(held.port, locale='de-DE').open()
    for screen in ('job/WO-9', 'item/WO-9/1'):
        tab.go(screen)
        tab.until(lambda: tab.page.locator('main .remark').inner_text(), 'a remark')
        assert tab.page.locator('main .remark').inner_text().startswith('Von diesem')
        assert not tab.page.locator('main a.button, main table').filter(visible=True).count()


def broken(tab: Tab) -> list[str]:
    words: list[str] = tab.page.evaluate(_BROKEN, MOST_LETTERS)
    return words


def outside(tab: Tab) -> list[str]:
    elements: list[str] = tab.page.evaluate(_OUTSIDE)
    return elements


def cut(tab: Tab) -> list[str]:
    texts: list[str] = tab.page.evaluate(_CUT, ', '.join(WHOLE))
    return texts
