"""An answer by keyboard alone, and a page that is ended while people look."""

from __future__ import annotations

import signal
from pathlib import Path

from cell_processes import STATELESS_CELL, StartCell
from fakes.quick_users import PASSWORD
from page.browsing import Tab
from page.conftest import Sit, StartPage
from page.stands import Stand, stand
from stream_readers import StreamReader, StuckReader

MOST_STEPS = 100
ENDS_WITHIN_S = 10.0
"""It takes 3 s at most, but not on a machine that is busy with other tests."""


def step_to(tab: Tab, selector: str) -> None:
    """Press the tabulator until something has the focus."""
    for _ in range(MOST_STEPS):
        if tab.page.evaluate('selector => document.activeElement.matches(selector)', selector):
            return
        tab.page.keyboard.press('Tab')
    raise AssertionError(f'{MOST_STEPS} steps do not lead to {selector}')


def test_a_hold_is_answered_by_keyboard_alone(tmp_path: Path, sit: Sit) -> None:
    with stand(tmp_path, login=True) as line:
        tab = sit(line.port).open()
        tab.until(lambda: tab.count('[data-hold]'), 'a hold')
        keys = tab.page.keyboard
        step_to(tab, '[data-offer="hold.retry"]')
        keys.press('Enter')
        tab.page.locator('dialog[data-dialog="login"]').wait_for()
        step_to(tab, '[name="username"]')
        keys.type('ann')
        keys.press('Tab')
        keys.type(PASSWORD)
        keys.press('Enter')
        tab.page.locator('dialog[data-dialog="hold.retry"]').wait_for()
        step_to(tab, '[name="reason"]')
        keys.type('turned it')
        step_to(tab, 'dialog [data-do="send"]')
        keys.press('Enter')
        tab.until(lambda: not tab.count('[data-hold="1"]'), 'the hold to be gone')
        [*_, decided] = line.happened('operator.decided')
        assert (decided['who'], decided['answer']) == ('ann', 'retry')
        assert decided['reason'] == 'turned it'


PHONE = {'width': 390, 'height': 844}

_IN_SIGHT = """
element => {
  const { x, y, width, height } = element.getBoundingClientRect();
  return element.contains(document.elementFromPoint(x + width / 2, y + height / 2));
}
"""

_BROKEN = """
() => [...document.querySelectorAll('dialog button')].filter((button) => {
  const words = button.textContent.split(' ').length;
  const lines = new Range();
  lines.selectNodeContents(button);
  return new Set([...lines.getClientRects()].map((one) => one.top)).size > words;
}).map((one) => one.textContent)
"""

IN_DOUBT = ['component_3a.TASK_A#2=cancel', 'component_3b.TASK_A#2=cancel']


def answers_at(seat: Stand) -> list[tuple[str, str]]:
    made = [event for event in seat.happened('operator.decided') if 'hold' in event]
    return [(event['hold'], event['answer']) for event in made]


def test_holds_alike_are_answered_in_one_list(tmp_path: Path, sit: Sit) -> None:
    with stand(tmp_path, jobs=1, quantity=4, fail=IN_DOUBT, speed=8.0) as line:
        tab = sit(line.port, viewport=PHONE, locale='de-DE').open()
        tab.until(lambda: tab.count('article[data-hold]') == len(IN_DOUBT), 'both holds')
        tab.page.locator('[data-do="several"]').click()
        dialog = tab.page.locator('dialog[data-dialog="several"]')
        boxes = dialog.locator('[name="hold"]')
        assert [boxes.nth(n).is_checked() for n in range(boxes.count())] == [False, False]
        dialog.locator('[data-do="send"]').click()
        warning = dialog.locator('.field-warning:visible').first
        warning.wait_for()
        assert warning.evaluate(_IN_SIGHT), 'no warning behind the buttons'
        assert not tab.page.evaluate(_BROKEN), 'no word is broken'
        assert answers_at(line) == []
        for n in range(boxes.count()):
            boxes.nth(n).check()
        dialog.locator('[value="mark_done"]').check()
        dialog.locator('[data-do="send"]').click()
        lacks_reason = dialog.locator('.field-warning:visible').first
        lacks_reason.wait_for()
        assert lacks_reason.evaluate(_IN_SIGHT), 'no missing reason behind the buttons'
        dialog.locator('[name="reason"]').fill('looked at both')
        dialog.locator('[data-do="send"]').click()
        dialog.wait_for(state='detached')
        assert answers_at(line) == [('1', 'mark_done'), ('2', 'mark_done')]


def test_ctrl_c_ends_page_with_open_readers(
    start_cell: StartCell, start_page: StartPage, sit: Sit
) -> None:
    cell = start_cell(STATELESS_CELL)
    cell.connect()
    page = start_page()
    tab = sit(page.port).open()
    tab.until_news()
    cell.run_small(quantity=1_000)
    reader, stuck = StreamReader(page.port), StuckReader(page.port)
    reader.wait_begun()
    tab.until(lambda: page.readers == 3, 'three readers')
    page.process.send(signal.SIGINT)
    assert page.process.wait(ENDS_WITHIN_S) == 0
    page.process.assert_clean()
    tab.until_news('page')
    for stream in (reader, stuck):
        stream.close()
