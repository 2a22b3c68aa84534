"""In local the page locks what moves the line, except at a panel, in both languages."""

from __future__ import annotations

import os
from functools import partial
from pathlib import Path
from typing import Any

from fakes.quick_users import write_users
from page.browsing import Tab
from page.conftest import Sit
from page.stands import stand
from served_process import PASSWORD
from web.stand_page import USERS

from bt_orchestrator.script.users.panels import Panels

RETRY = '[data-hold="1"] [data-offer="hold.retry"]'


def locked(tab: Tab, offer: str) -> bool:
    return tab.page.locator(offer).first.get_attribute('data-locked') is not None


def picture(tab: Tab, name: str) -> None:
    folder = os.environ.get('LOCAL_PICTURES')
    if folder:
        tab.page.screenshot(path=Path(folder) / f'{name}.png')


def test_7_8_only_panel_moves_line_in_local(tmp_path: Path, sit: Sit) -> None:
    with stand(tmp_path, jobs=2, login=True) as line:
        panels = Panels(users=('eve',))
        write_users(tmp_path / 'users.yaml', USERS, PASSWORD, panels=panels)
        person: Any = {'viewport': {'width': 1280, 'height': 900}}
        ann, eve = (sit(line.port, **person).open() for _ in range(2))
        for tab, name in ((ann, 'ann'), (eve, 'eve')):
            tab.until_news()
            tab.log_in(name)
            tab.until(partial(tab.count, RETRY), 'a hold')
        assert not locked(ann, RETRY)
        for name in ('.in-local', '.unsafe'):
            assert not ann.page.locator(name).is_visible()

        line.ask('cell.local')
        for tab in (ann, eve):
            tab.page.locator('.in-local', has_text='Local').wait_for()
        ann.until(lambda: locked(ann, RETRY), 'what moves is locked')
        assert not locked(eve, RETRY)
        assert not locked(ann, '[data-offer="cell.abort"]')
        picture(ann, 'local_elsewhere')
        ann.page.locator(RETRY).click()
        message = ann.page.locator('dialog[data-dialog="not-allowed"]').inner_text()
        assert 'The line is in local: only its panels may move it.' in message
        picture(ann, 'local_refused')
        ann.page.keyboard.press('Escape')

        eve.answer('1', 'retry', 'looked at it')
        (decided,) = line.happened('operator.decided')[-1:]
        assert (decided['who'], decided['known']) == ('eve', 'page panel')
        eve.page.locator('[data-menu="later"] > summary').click()
        picture(eve, 'local_panel')
        eve.page.locator('[data-offer="cell.remote"]').click()
        eve.confirm('cell.remote', 'done at section 3')
        ann.page.locator('.in-local').wait_for(state='hidden')
        assert [event['control'] for event in line.happened('cell.control_changed')] == [
            'local',
            'remote',
        ]

        line.cell.node._gateway.say_of_safety('its value is False')
        message = 'Safety input not ready: its value is False'
        ann.page.locator('.unsafe', has_text=message).wait_for()
        picture(ann, 'unsafe')

        german = sit(line.port, locale='de-DE', **person).open()
        line.ask('cell.local')
        german.page.locator('.in-local', has_text='Lokal').wait_for()
        message = 'Sicherheitseingang nicht bereit: sein Wert ist False'
        german.page.locator('.unsafe', has_text=message).wait_for()
        picture(german, 'local_german')
