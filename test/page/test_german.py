"""A German page is German: only names, and what devices and people said, stay as they are."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from page.browsing import Person
from page.conftest import Sit
from page.stands import Stand, stand

from bt_orchestrator.model.jobs.order import Terms, WorkOrder

SCREENS = ('overview', 'queue', 'section/3', 'section/4', 'component/component_3a', 'job/WO-1001')
FREE = ('aborted by the simulated controller', 'its grip is worn')
"""What a device and a person said."""

_ENGLISH = re.compile(
    r'\b(the|of|for|is|to|and|by|which|with|waiting|waits|taken|not|out|done|item|section|belt'
    r'|if|free|cycle|jobs|rest|parallel)\b'
)

_SAID = """
() => [...document.querySelectorAll('.picture-room :is(text, title)')]
  .map((one) => one.textContent.trim()).filter(Boolean)
"""


@pytest.fixture(scope='module')
def held(tmp_path_factory: pytest.TempPathFactory, browser: Any) -> Iterator[Stand]:
    """Give a line that is Held, and a component out of service."""
    with stand(tmp_path_factory.mktemp('stand')) as line:
        person = Person(browser, f'http://127.0.0.1:{line.port}')
        tab = person.open()
        tab.until(lambda: tab.count('[data-hold]'), 'a hold')
        line.ask('component.out_of_service', FREE[1], component='component_2a')
        tab.until(lambda: tab.count('[data-component="component_2a"]'), 'what is out of service')
        person.leave()
        yield line


def test_no_screen_says_english_words(held: Stand, sit: Sit) -> None:
    tab = sit(held.port, locale='de-DE').open()
    tab.until_news()
    untranslated = {}
    for screen in SCREENS:
        tab.go(screen)
        tab.until_quiet()
        if english := english_lines(tab.page.locator('body').inner_text()):
            untranslated[screen] = english
    assert not untranslated


def test_why_the_line_waits_is_said_in_german(held: Stand, sit: Sit) -> None:
    tab = sit(held.port, locale='de-DE').open('why')
    for reason in tab.page.locator('.reason').all():
        reason.click()
    tab.until_quiet()
    assert tab.count('.reason') > 3
    assert not english_lines(tab.page.locator('[aria-labelledby="why-reasons"]').inner_text())


def test_line_picture_is_german_with_all_details(held: Stand, sit: Sit) -> None:
    tab = sit(held.port, locale='de-DE').open('why')
    tab.until(lambda: tab.count('.picture-room svg [data-part]'), 'the picture')
    texts = tab.page.evaluate(_SAID)
    assert 'gleichzeitig' in texts
    assert 'Platz 4: WO-1001/3' in texts
    assert len(texts) > 100
    assert not [line for text in texts for line in english_lines(text)]


def test_order_without_valid_quantity_is_refused_in_german(held: Stand, sit: Sit) -> None:
    tab = sit(held.port, locale='de-DE').open('order')
    tab.until_news()
    form = tab.page.locator('form.order-form')
    form.locator('[name="script"]').select_option('inspect_and_assemble')
    for quantity, message in (('', 'Bitte die Stückzahl angeben.'), ('7,5', 'Eine ganze Zahl')):
        form.locator('[name="quantity"]').fill(quantity)
        form.locator('[data-do="order"]').click()
        form.get_by_text(message).wait_for()
        assert not english_lines(form.inner_text())


def test_what_the_cell_refuses_is_said_in_german(held: Stand, sit: Sit) -> None:
    """Somebody else was quicker."""
    tab = sit(held.port, locale='de-DE').open('component/component_2a')
    tab.until_news()
    tab.page.locator('[data-offer="component.in_service"]').click()
    dialog = tab.page.locator('dialog[data-dialog="component.in_service"]')
    dialog.locator('[name="reason"]').fill('neuer Greifer')
    held.ask('component.in_service', component='component_2a')
    dialog.locator('[data-do="send"]').click()
    refused = dialog.locator('[data-answer="refused"]')
    refused.wait_for()
    assert refused.inner_text().strip() == (
        'Abgelehnt; es ist nichts geschehen. component_2a ist in Betrieb; jetzt außer Betrieb: '
        'keine'
    )
    held.ask('component.out_of_service', FREE[1], component='component_2a')
    tab.go('alarms')
    note = tab.page.locator('main').get_by_text('component_2a ist in Betrieb; jetzt außer Betrieb')
    note.first.wait_for()


def test_executed_command_is_reported_in_german(held: Stand, sit: Sit) -> None:
    tab = sit(held.port, locale='de-DE').open('component/component_2a')
    tab.until_news()
    tab.page.locator('[data-offer="component.in_service"]').click()
    tab.confirm('component.in_service', 'neuer Greifer')
    note = tab.page.locator('.note-words', has_text='Ausgeführt. component_2a ist in Betrieb')
    note.wait_for()
    held.ask('component.out_of_service', FREE[1], component='component_2a')


def test_the_tree_is_german(held: Stand, sit: Sit) -> None:
    tab = sit(held.port, locale='de-DE').open('tree')
    tab.until(lambda: tab.count('.twig') > 1, 'the tree')
    tab.page.locator('.screen-head button').first.click()
    tab.until(lambda: not tab.count('.twig[aria-expanded="false"]'), 'all branches to be open')
    text = tab.page.locator('[role="tree"]').inner_text()
    assert 'Störung, wenn es misslingt' in text
    assert 'wartet auf Antwort auf Störung 1 (mark: ' in text
    assert len(text.splitlines()) > 100
    assert not english_lines(text)


def test_tree_of_script_with_rounds_is_german(tmp_path: Path, sit: Sit) -> None:
    with stand(tmp_path, jobs=1, quantity=1, fail=['component_3b.TASK_B#2=abort']) as line:
        order = WorkOrder('rework_by_weight', 'WO-7', 2, {}, Terms())
        assert line.cell.queue(order).accepted
        tab = sit(line.port, locale='de-DE').open('tree')
        tab.page.locator('[role="tree"]').get_by_text('bis zu 2 weitere Runden').first.wait_for()


def test_english_words_are_found(held: Stand, sit: Sit) -> None:
    assert english_lines('wartet auf Zone a\nwaiting for zone a') == ['waiting for zone a']
    tab = sit(held.port, locale='en-GB').open()
    tab.until_news()
    assert len(english_lines(tab.page.locator('body').inner_text())) > 5


def english_lines(text: str) -> list[str]:
    for phrase in FREE:  # of which a card of the picture has room for the beginning
        text = re.sub(rf'{phrase[:15]}[^)\n]*', '', text)
    return [line for line in text.splitlines() if _ENGLISH.search(line)]


def test_order_errors_are_german_at_each_field(tmp_path: Path, sit: Sit) -> None:
    with stand(tmp_path, fail=['none']) as line:
        tab = sit(line.port, locale='de-DE').open('order')
        tab.until_news()
        source = tab.page.locator('[name="script"]')
        tab.until(lambda: source.locator('option').count() > 1, 'the scripts')
        source.select_option('inspect_and_assemble')
        tab.page.locator('[name="order"]').fill('A/1')
        tab.page.locator('[name="quantity"]').fill('99999999')
        tab.page.locator('[data-do="order"]').click()
        for field, words in (
            ('order', '`A/1` kann keine Auftragsnummer sein: ein Schrägstrich trennt'),
            ('quantity', '99999999 Teile sind zu viele: Ein Auftrag dieser Zelle hat höchstens'),
        ):
            tab.page.locator(f'[name="{field}"][aria-invalid="true"]').wait_for()
            warning = tab.page.locator(f'.field:has([name="{field}"]) .field-warning')
            assert words in warning.inner_text()
