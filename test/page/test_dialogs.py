"""Dialogs name what they are about, whole, and end with it; the focus never gets lost."""

from __future__ import annotations

from collections.abc import Iterator
from threading import Timer
from typing import Any

import pytest
from page.browsing import Person, Tab
from page.conftest import Sit
from page.stands import Stand, stand

from bt_orchestrator.model.by import By, Known, Role
from bt_orchestrator.model.jobs.order import Terms, WorkOrder
from bt_orchestrator.model.requests import ask

FAULTS = ['component_3a.TASK_A#3=abort', 'component_3a.TASK_A#4=false']
"""The third item is held, and held again when it is retried."""
LONG = 'WO-1123-1909-VERPACKUNG-LINKS-B'
"""The job behind that of the held item."""
ITEM = 'WO-1001/3'
PHONE = {'width': 390, 'height': 844}

_FOCUS = '() => document.activeElement.tagName'

_CUT = """
selector => [...document.querySelectorAll(selector)]
  .filter((one) => one.scrollWidth > one.clientWidth + 1
    || one.getBoundingClientRect().right > document.documentElement.clientWidth)
  .map((one) => one.textContent)
"""


@pytest.fixture(scope='module')
def line(tmp_path_factory: pytest.TempPathFactory, browser: Any) -> Iterator[Stand]:
    """Give a line with items of two jobs, the last item of the first one held."""
    folder = tmp_path_factory.mktemp('stand')
    with stand(folder, jobs=1, quantity=3, fail=FAULTS, speed=8.0) as held_line:
        order = WorkOrder(held_line.cell.script, LONG, 4, {}, Terms())
        assert held_line.cell.queue(order).accepted
        person = Person(browser, f'http://127.0.0.1:{held_line.port}')
        tab = person.open()
        tab.until(lambda: tab.count('[data-hold="1"]'), 'a hold')
        person.leave()
        yield held_line


def test_dialogs_and_focus_follow_hold_abort_and_loss(line: Stand, sit: Sit) -> None:
    tab = sit(line.port, viewport=PHONE).open()
    tab.until_news()
    slots_name_their_jobs(tab)
    a_hold_that_somebody_else_answers_closes_its_dialog(tab, line)
    focus_goes_on_after_an_answer(tab)
    clear_shows_each_item_whole(tab, line)
    verbs_of_the_command_line_are_named_as_buttons(tab)
    old_news_name_only_what_can_be_pressed(tab, line)
    a_command_waits_for_fresh_news(tab, line)


def slots_name_their_jobs(tab: Tab) -> None:
    tab.until(lambda: tab.count('.slots[data-jobs]'), 'two jobs on the belt')
    assert tab.page.locator('[data-slot="3"] .item-id').inner_text().split() == [LONG, '/1']
    ids = ':is(.slot, .section-card) :is(.item-id, .item-job)'
    assert not tab.page.evaluate(_CUT, ids)
    assert tab.too_wide() == 0


def a_hold_that_somebody_else_answers_closes_its_dialog(tab: Tab, line: Stand) -> None:
    tab.page.locator('[data-hold="1"] [data-offer="hold.skip"]').click()
    dialog = tab.page.locator('dialog[data-dialog="hold.skip"]')
    assert ITEM in dialog.locator('h2').inner_text()
    ann = By('Ann', 'the stand', 'turned it', Role.ENGINEER, Known.ROS)
    assert line.cell.ask(ask('hold.retry', ann, hold='1')).accepted
    dialog.wait_for(state='detached')
    note = tab.page.locator('[data-note="told"]')
    note.wait_for()
    assert 'Somebody who claims to be Ann has answered “Retry”. “turned it”' in note.inner_text()
    assert 'Nothing was sent from here.' in note.inner_text()
    tab.until(lambda: tab.count('[data-hold="2"]'), 'the next hold')
    wait = tab.page.locator('[data-section="4"] .section-wait').last.inner_text()
    assert 'done, but without success' in wait


def focus_goes_on_after_an_answer(tab: Tab) -> None:
    tab.answer('2', 'mark_done', 'looked at it')
    tab.until(lambda: not tab.count('[data-hold="2"]'), 'the hold to be gone')
    assert tab.page.evaluate(_FOCUS) != 'BODY'


def clear_shows_each_item_whole(tab: Tab, line: Stand) -> None:
    line.ask('cell.abort')
    clear = tab.page.locator('header [data-offer="cell.clear"]')
    clear.click()
    dialog = tab.page.locator('dialog[data-dialog="cell.clear"]')
    choices = dialog.locator('.choice-words').all_inner_texts()
    assert f'{LONG}/1' in choices
    assert ITEM in choices
    assert not tab.page.evaluate(_CUT, '.belt-row, .choice-words')
    bar, title = (tab.page.locator(selector).bounding_box() for selector in ('#top', 'dialog h2'))
    assert bar is not None
    assert title is not None
    assert title['y'] >= bar['y'] + bar['height']
    dialog.locator('[data-do="leave"]').click()
    assert tab.page.evaluate(_FOCUS) == 'BUTTON'


def verbs_of_the_command_line_are_named_as_buttons(tab: Tab) -> None:
    script = "async words => (await import('/static/core/requests.js')).withButtons(words)"
    for words, shown in (
        ('it is released with resume', 'it is released with “Resume”'),
        ('start it again and say abort once more', 'start it again and say “Abort” once more'),
        ('answer hold 3 with mark_done first', 'answer hold 3 with “It was done” first'),
        ('see bt-orchestrator remove-item WO-1/2', 'see “Item was removed”'),
        ('done with WO-1/2, with hold 3, with another', ''),
    ):
        assert tab.page.evaluate(script, words) == (shown or words)


def old_news_name_only_what_can_be_pressed(tab: Tab, line: Stand) -> None:
    line.cell.switch()
    tab.until_news('node')
    reason = tab.page.locator('.state-why').inner_text()
    offered = tab.page.locator('header [data-emergency]').all_inner_texts()
    assert 'No command can be given' in reason if not offered else offered[0] in reason
    assert 'Stop' not in reason


def a_command_waits_for_fresh_news(tab: Tab, line: Stand) -> None:
    line.cell.switch()
    tab.until_news()
    tab.page.locator('header [data-offer="cell.clear"]').click()
    line.cell.switch()
    tab.until_news('node')
    again = Timer(1.0, line.cell.switch)
    again.start()
    tab.confirm('cell.clear', 'looked')
    again.join()
    tab.until(lambda: tab.count('[data-part="cell"][data-state="Stopped"]'), 'a clear cell')
