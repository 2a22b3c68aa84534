"""Why the line waits, the behaviour tree, and what sections, jobs and items tell of the past."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from fakes.operator import engineer
from page.browsing import Tab
from page.conftest import Sit
from page.stands import Stand, stand
from web.stand_cell import StandCell

from bt_orchestrator.model.requests import ask
from bt_orchestrator.sim.virtual_link import VirtualLink

FAIL = 'component_3b.TASK_A#2=abort'
READABLE = 1.1
"""Pixels a point of the picture, as in `static/parts/pan_zoom.js`."""
HELD, ITEM = 'weigh', 'WO-1001/2'
"""The task and the item of that failure, in section 4."""


@pytest.fixture
def line(tmp_path: Path) -> Iterator[Stand]:
    """Give a line in quick time that comes to a hold."""
    with stand(tmp_path, jobs=2, quantity=3, fail=[FAIL], speed=10.0) as held_line:
        yield held_line


@pytest.fixture
def open_held(line: Stand, sit: Sit) -> Callable[[str], Tab]:
    """Give a function that opens a screen once the line is held."""

    def opened(screen: str) -> Tab:
        tab = sit(line.port).open(screen)
        tab.page.locator('.state[data-state="Held"]').wait_for()
        return tab

    return opened


def answer(cell: StandCell, word: str, reason: str) -> None:
    """Answer the hold."""
    with cell.lock:
        link = VirtualLink(cell.node)
        try:
            given = link.ask(ask(f'hold.{word}', engineer('Ann', 'a test', reason), hold='1'))
        finally:
            link.close()
    assert given.accepted, given


def test_plant_cells_are_listed_with_page_links(line: Stand, sit: Sit) -> None:
    page = sit(line.port).open('cells').page
    rows = page.locator('.things tbody tr')
    rows.nth(1).wait_for()
    words = [[cell.strip() for cell in row.split('\t')] for row in rows.all_inner_texts()]
    assert [(row[0], row[1], row[-1]) for row in words] == [
        ('line_1', 'Held: Waits for an answer', '2 s, gaps: 1'),
        ('line_2', 'Working', 'never complete'),
    ]
    assert rows.nth(0).locator('a').get_attribute('href') == 'http://line-1:8080/'
    assert rows.nth(1).locator('a').count() == 0
    assert page.locator('nav a[data-screen="cells"][aria-current="page"]').is_visible()


# --- why ---------------------------------------------------------------------------------------


def test_keys_open_chain_from_wait_to_cause(
    open_held: Callable[[str], Tab],
) -> None:
    page = open_held('why').page
    cause = page.locator('.causes li').first
    assert HELD in cause.inner_text()
    assert ITEM in cause.inner_text()
    belt = page.locator('.reason[data-part="belt"]')
    belt.focus()
    page.keyboard.press('Enter')
    steps = page.locator('.chain > li')
    assert [step.split('\n')[0] for step in steps.all_inner_texts()] == [
        'Belt',
        'Section 4',
        'Hold 1',
    ]
    assert HELD in page.locator('.chain > .root').inner_text()
    page.locator(f'.picture-room [data-part="task.{HELD}"].is-root').wait_for()
    assert page.locator('.is-on-way').count() == 3
    page.keyboard.press('Enter')
    assert page.locator('.chain, .is-root').count() == 0


def test_click_in_picture_opens_chain_of_part(
    open_held: Callable[[str], Tab],
) -> None:
    page = open_held('why').page
    whole = page.get_by_role('button', name='The whole line')
    whole.click()
    page.locator('[data-part="slot.2"]').click()
    assert page.locator('.reason[aria-expanded="true"]').get_attribute('data-part') == 'section/2'
    assert page.evaluate('document.activeElement.dataset.part') == 'section/2'
    whole.click()
    page.locator('[data-part^="flag."] text').first.click()
    assert page.locator('.reason[aria-expanded="true"]').get_attribute('data-part') == 'section/2'
    page.locator('.picture-room [data-part="belt"] text').first.click()
    assert page.locator('.reason[aria-expanded="true"]').get_attribute('data-part') == 'belt'


def test_keys_buttons_and_pointer_zoom_and_move_picture(
    open_held: Callable[[str], Tab],
) -> None:
    page = open_held('why').page
    room = page.locator('.picture-room')
    page.locator('.picture-room svg').wait_for()

    def seen() -> list[float]:
        text = page.locator('.picture-room > svg').get_attribute('viewBox') or ''
        return [float(number) for number in text.split()]

    room.focus()
    page.keyboard.press('0')
    whole = seen()
    page.keyboard.press('+')
    page.keyboard.press('+')
    closer = seen()
    assert closer[2] < whole[2] / 1.5
    page.keyboard.press('ArrowRight')
    assert seen()[0] > closer[0]
    page.keyboard.press('0')
    assert seen() == whole
    page.get_by_role('button', name='Closer').click()
    page.get_by_role('button', name='Closer').click()
    before = seen()
    box = room.bounding_box()
    assert box is not None
    page.mouse.move(box['x'] + 300, box['y'] + 300)
    page.mouse.down()
    page.mouse.move(box['x'] + 200, box['y'] + 300, steps=5)
    page.mouse.up()
    assert seen()[0] > before[0]
    assert page.locator('.reason[aria-expanded="true"]').count() == 0, 'a drag is no click'


def test_resized_window_resets_picture_unless_view_is_chosen(
    open_held: Callable[[str], Tab],
) -> None:
    tab = open_held('why')
    page = tab.page
    page.locator('.picture-room svg').wait_for()

    def seen() -> tuple[float, float]:
        """Return the scale of the picture, and the width that is seen of it."""
        scale, width = page.evaluate("""() => {
          const svg = document.querySelector('.picture-room svg');
          return [svg.getScreenCTM().a, svg.viewBox.baseVal.width];
        }""")
        return round(float(scale), 2), float(width)

    page.set_viewport_size({'width': 768, 'height': 1024})
    tab.until(lambda: seen()[0] == READABLE, 'text that can be read')
    narrow = seen()[1]
    page.set_viewport_size({'width': 1366, 'height': 768})
    tab.until(lambda: seen()[0] >= READABLE and seen()[1] > 1.5 * narrow, 'more of the line')
    page.get_by_role('button', name='The whole line').click()
    whole = seen()[0]
    assert whole < READABLE
    page.set_viewport_size({'width': 1400, 'height': 768})
    page.evaluate('() => new Promise(requestAnimationFrame)')
    assert seen()[0] == whole


# --- tree --------------------------------------------------------------------------------------


def test_keys_walk_tree_fetched_only_while_shown(line: Stand, sit: Sit) -> None:
    person = sit(line.port)
    tab = person.open('tree')
    page = tab.page
    root = page.locator('[role="treeitem"]').first
    root.wait_for()
    assert root.get_attribute('aria-expanded') == 'true'
    lines = page.locator('[role="treeitem"]')
    root.focus()
    page.keyboard.press('ArrowDown')
    assert page.evaluate('document.activeElement.getAttribute("aria-level")') == '2'
    page.keyboard.press('ArrowLeft')
    page.keyboard.press('ArrowLeft')
    page.keyboard.press('ArrowLeft')
    tab.until(lambda: lines.count() == 1, 'the root to be folded')
    page.keyboard.press('Enter')
    tab.until(lambda: lines.count() > 1, 'the root to be open')
    page.locator('.state[data-state="Held"]').wait_for()
    tab.go('overview')

    def asked() -> int:
        return sum('/api/tree' in url for url in person.requested)

    before, seq = asked(), tab.seq
    answer(line.cell, 'retry', 'a test')
    tab.until(lambda: tab.seq > seq + 100, 'some seconds of work')
    assert asked() <= before + 1, 'the one that was on its way'


# --- past --------------------------------------------------------------------------------------


def test_item_story_tells_failure_answer_and_end(
    line: Stand, open_held: Callable[[str], Tab]
) -> None:
    tab = open_held(f'item/{ITEM}')
    page = tab.page
    page.locator('[data-kind="held"]').wait_for()
    answer(line.cell, 'retry', 'the scale was clean')
    page.locator('[data-kind="ended"]').wait_for()
    entries = page.locator('.told').all_inner_texts()
    places = [
        next(n for n, entry in enumerate(entries) if all(word in entry for word in words))
        for words in (
            ('It began',),
            (HELD, 'component_3b', 'the controller gave up', 'simulated controller'),
            ('Hold 1',),
            ('Ann', 'Retry', 'the scale was clean'),
            (HELD, 'attempt 2', 'done in'),
            ('packed',),
        )
    ]
    assert places == sorted(places)
    page.locator('.told summary', has_text='Results').first.click()
    assert 'measurement' in page.locator('.told details[open]').inner_text()


def test_a_section_shows_hold_tasks_times_and_failures(open_held: Callable[[str], Tab]) -> None:
    tab = open_held('section/4')
    page = tab.page
    assert page.locator('[data-hold] [data-offer="hold.retry"]').count() == 1
    assert page.locator('.task-list [data-mark="held"]').count() == 1
    failure = page.locator('.history tr', has_text='aborted by the simulated controller')
    failure.wait_for()
    assert ITEM in failure.inner_text()
    times = page.locator('.history tr', has_text='component_3a.TASK_A')
    assert times.locator('svg.times rect').count() >= 1
    page.locator('.task-list').get_by_role('link', name='component_3b').click()
    tab.until_screen('component/component_3b')
    assert page.locator('[data-hold]').count() == 1


def test_job_items_are_listed_and_downloaded(
    open_held: Callable[[str], Tab], tmp_path: Path
) -> None:
    tab = open_held('jobs')
    page = tab.page
    page.get_by_role('link', name='WO-1001', exact=True).click()
    tab.until_screen('job/WO-1001')
    page.locator('.things tr', has_text=ITEM).first.wait_for()
    with page.expect_download() as waiting:
        page.get_by_role('link', name='Items as CSV').click()
    file = tmp_path / 'items.csv'
    waiting.value.save_as(file)
    assert waiting.value.suggested_filename == 'WO-1001-items.csv'
    with file.open(newline='', encoding='utf-8') as text:
        items = [row['item'] for row in csv.DictReader(text)]
    assert ITEM in items
    page.locator('main').get_by_role('link', name=ITEM).first.click()
    tab.until_screen(f'item/{ITEM}')
    page.get_by_role('heading', name=f'Item {ITEM}').wait_for()
    with page.expect_download() as waiting:
        page.get_by_role('link', name='Record to print').click()
    record = tmp_path / 'item.html'
    waiting.value.save_as(record)
    assert waiting.value.suggested_filename == f'{ITEM.replace("/", "-")}.html'
    assert 'What happened' in record.read_text()


# --- a component --------------------------------------------------------------------------------


def test_component_leaves_and_returns_to_service(line: Stand, sit: Sit) -> None:
    tab = sit(line.port).open('component/component_3b')
    page = tab.page
    page.locator('[data-offer="component.out_of_service"]').click()
    tab.confirm('component.out_of_service', 'gripper worn')
    trouble = page.locator('.screen .trouble')
    trouble.get_by_text('gripper worn').wait_for()
    assert 'out of service since' in trouble.inner_text()
    (out,) = line.happened('component.out_of_service')
    assert out['component'] == 'component_3b'
    page.locator('[data-offer="component.in_service"]').click()
    tab.confirm('component.in_service', 'new gripper')
    page.locator('[data-offer="component.out_of_service"]').wait_for()
    assert not trouble.is_visible()
