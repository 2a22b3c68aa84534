"""Manual mode at the page: an engineer at a panel runs one task after the other."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from fakes.quick_users import write_users
from page.axe import barriers
from page.browsing import Tab
from page.conftest import Sit
from page.stands import Stand, stand
from served_process import PASSWORD
from web.stand_page import USERS

from bt_orchestrator.script.users.panels import Panels


def picture(tab: Tab, name: str) -> None:
    folder = os.environ.get('MANUAL_PICTURES')
    if folder:
        tab.page.screenshot(path=Path(folder) / f'{name}.png', full_page=True)


def goal_state(line: Stand) -> str:
    with line.cell.lock:
        goal = line.cell.node.running.overview.status(0.0).manual
    return '' if goal is None else goal.state


def run_task(tab: Tab, component: str, task: str, reason: str, **args: str) -> None:
    form = tab.page.locator('.manual form')
    form.locator('[name="component"]').select_option(component)
    form.locator('[name="task"]').select_option(task)
    for name, value in args.items():
        form.locator(f'[name="args.{name}"]').fill(value)
    form.locator('[name="reason"]').fill(reason)
    form.locator('[data-do="run"]').click()


def shown(tab: Tab, state: str) -> None:
    tab.page.locator(f'[data-manual="{state}"]').wait_for()


def test_7_11_an_engineer_at_a_panel_runs_single_tasks(tmp_path: Path, sit: Sit) -> None:
    with stand(tmp_path, jobs=0, login=True, fail=['component_3b.#1=hang'], speed=1.0) as line:
        panels = Panels(users=('eve',))
        write_users(tmp_path / 'users.yaml', USERS, PASSWORD, panels=panels)
        person: Any = {'viewport': {'width': 1280, 'height': 900}}
        ann, eve = (sit(line.port, **person).open() for _ in range(2))
        for tab, name in ((ann, 'ann'), (eve, 'eve')):
            tab.until_news()
            tab.log_in(name)
        assert not eve.page.locator('nav [data-screen="manual"]').is_visible()
        line.ask('cell.local')
        eve.page.locator('nav [data-screen="manual"]').click()
        picture(eve, 'manual_before')
        eve.page.locator('.manual [data-offer="cell.manual"]').click()
        eve.confirm('cell.manual', 'the gripper of 3a')
        eve.page.locator('.in-local', has_text='Manual mode').wait_for()

        args = {'special_argument_2': 'fast'}
        run_task(eve, 'component_3a', 'TASK_A', 'to look', **args)
        warning = eve.page.locator('.manual [data-check="wrong"]')
        warning.filter(has_text='must be a number').wait_for()
        picture(eve, 'manual_refused')
        run_task(eve, 'component_3a', 'TASK_A', 'to look', special_argument_2='1.5')
        shown(eve, 'running')
        picture(eve, 'manual_running')
        assert barriers(eve) == []
        shown(eve, 'done')
        picture(eve, 'manual_done')
        (started,) = line.happened('task.started')
        assert started['args'] == {'special_argument_2': 1.5}
        (asked,) = line.happened('manual.asked')
        assert (asked['who'], asked['known']) == ('eve', 'page panel')
        assert line.happened('task.cancel_requested') == []

        run_task(eve, 'component_3b', 'TASK_A', 'once more')
        shown(eve, 'running')
        eve.page.locator('.manual [data-offer="component.cancel_task"]').click()
        eve.until(lambda: goal_state(line) == 'canceled', 'its end')
        eve.page.locator('dialog[data-dialog="reason-afterwards"]').wait_for()
        eve.page.keyboard.press('Escape')

        ann.page.goto(f'http://127.0.0.1:{line.port}/#/manual')
        ann.page.locator('.manual [data-do="run"]').wait_for()
        assert ann.page.locator('.manual [data-do="run"]').get_attribute('data-locked') is not None
        picture(ann, 'manual_elsewhere')

        eve.page.locator('.manual [data-offer="cell.production"]').click()
        picture(eve, 'manual_leaving')
        eve.confirm('cell.production', 'it is empty')
        eve.page.locator('.in-local', has_text='Local').wait_for()
        assert [change['mode'] for change in line.happened('cell.unit_mode_changed')] == [
            'manual',
            'production',
        ]
        german = sit(line.port, locale='de-DE', **person).open('manual')
        german.page.locator('.manual h1', has_text='Handbetrieb').wait_for()
        picture(german, 'manual_german')


def test_7_11_7_closing_sending_page_cancels_task(tmp_path: Path, sit: Sit) -> None:
    with stand(tmp_path, jobs=0, login=True, fail=['component_3a.#1=hang'], speed=1.0) as line:
        panels = Panels(users=('eve',))
        write_users(tmp_path / 'users.yaml', USERS, PASSWORD, panels=panels)
        for request in ('cell.local', 'cell.manual'):
            line.ask(request)
        eve = sit(line.port).open('manual')
        eve.until_news()
        eve.log_in('eve')
        run_task(eve, 'component_3a', 'TASK_A', 'to look')
        shown(eve, 'running')
        other = sit(line.port).open('manual')
        other.until_news()
        other.log_in('eve')
        shown(other, 'running')
        eve.page.close()
        shown(other, 'canceled')
        (cancelled,) = line.happened('task.cancel_requested')
        assert cancelled['cause'] == 'panel_lost'
