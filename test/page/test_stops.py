"""An operator gives stops their reasons on the page, while the node is killed twice.

With SHIFT_PICTURES=FOLDER pictures of the screen stay in that folder.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any

import pytest
from cell_processes import CellProcesses
from fakes.shipped import REASONS, REFERENCE_CELL, TREES
from page.browsing import Tab
from page.conftest import Sit, StartPage

SHIFTS = 'shifts: {all: {from: 00:00, to: 24:00}}\nzone: UTC\n'


class Plant:
    """A cell with the files of a plant."""

    def __init__(self, folder: Path, *faults: str) -> None:
        """Start it."""
        self.folder = folder
        self.journal = folder / 'journal.sqlite3'
        self.shifts = folder / 'shifts.yaml'
        self.shifts.write_text(SHIFTS)
        self.cell = CellProcesses(
            folder / 'cell',
            REFERENCE_CELL.read_text(),
            fail=faults,
            speed=4,
            sim_options=['--result-timeout', '600'],
            run_options=[
                '--trust-local-doors', '--journal', str(self.journal), '--trees', str(TREES),
                '--reasons', str(REASONS),
            ],
        )  # fmt: skip
        self.cell.connect()

    @property
    def page_options(self) -> list[str]:
        """Options of the page."""
        given = {'journal': self.journal, 'trees': TREES, 'shifts': self.shifts}
        given |= {'reasons': REASONS, 'cell': REFERENCE_CELL}
        return [word for name, value in given.items() for word in (f'--{name}', str(value))]

    def report(self) -> dict[str, Any]:
        """Return what `report` says in a process of its own."""
        words = ['report', '--journal', str(self.journal), '--reasons', str(REASONS), '--json']
        program = [sys.executable, '-m', 'bt_orchestrator', *words]
        ended = subprocess.run(program, check=False, capture_output=True, text=True)
        assert ended.returncode == 0, ended.stderr
        report: dict[str, Any] = json.loads(ended.stdout)
        return report


@pytest.fixture
def plant(tmp_path: Path) -> Iterator[Plant]:
    """Give a cell with the files of a plant, whose component_3a fails at its first task."""
    yield from started(tmp_path, 'component_3a.TASK_A#1=abort')


@pytest.fixture
def sound_plant(tmp_path: Path) -> Iterator[Plant]:
    """Give a cell with the files of a plant."""
    yield from started(tmp_path)


def started(folder: Path, *faults: str) -> Iterator[Plant]:
    plant = Plant(folder, *faults)
    try:
        yield plant
    finally:
        plant.cell.close()


def choose(tab: Tab, dialog: str, code: str) -> None:
    """Choose a reason in the form of a request."""
    field = tab.page.locator(f'dialog[data-dialog="{dialog}"] select[name="code"]')
    field.select_option(code)


def stop_of(tab: Tab, words: str, known: Collection[str] = ()) -> str:
    """Return the name of a stop of the list whose row has some words, and that is a new one."""
    buttons = tab.page.locator('.stops tbody tr', has_text=words).locator('[data-stop]')
    stops: list[str] = []

    def look() -> bool:
        names = buttons.evaluate_all('all => all.map((one) => one.dataset.stop)')
        stops[:] = [name for name in names if name not in known]
        return bool(stops)

    tab.until(look, f'a stop with {words}')
    return stops[0]


def classify(tab: Tab, stop: str, code: str) -> None:
    """Give a stop of the list a reason."""
    tab.page.locator(f'[data-stop="{stop}"]').click()
    choose(tab, 'stop.classify', code)
    tab.confirm('stop.classify', 'seen at the line')
    given = f'tr:has([data-stop="{stop}"]) [data-code="{code}"]'
    tab.until(lambda: tab.count(given), f'the reason {code} of {stop}')


def picture(tab: Tab, name: str) -> None:
    """Keep what stands on the screen, if somebody wants to look at it."""
    folder = os.environ.get('SHIFT_PICTURES')
    if folder:
        tab.until_quiet()
        tab.page.screenshot(path=Path(folder) / f'{name}.png', full_page=True)


@pytest.mark.long
def test_operator_classifies_stops_across_two_node_kills(
    plant: Plant, start_page: StartPage, sit: Sit
) -> None:
    cell = plant.cell
    tab = sit(start_page(*plant.page_options).port).open()
    tab.until_news()
    tab.log_in('engineer')
    cell.watch.submit('inspect_and_assemble', quantity=6)

    # an answer with a reason of the form
    hold = tab.page.locator('[data-hold] [data-offer="hold.retry"]')
    tab.until(hold.count, 'the hold of component_3a')
    tab.until(lambda: tab.count('.shift-stopped:visible'), 'the stop of some seconds')
    hold.first.click()
    choose(tab, 'hold.retry', 'GRIPPER')
    picture(tab, 'answer')
    tab.confirm('hold.retry', 'the part was turned')

    names: dict[int, str] = {}
    for kill in (1, 2):
        cell.node.kill()
        tab.until_news('node')
        cell.start_node()
        cell.node.wait_ready()
        tab.until_news()
        tab.go('overview')
        resume = tab.page.locator('main [data-hold] [data-offer="cell.resume"]')
        tab.until(resume.count, 'the hold of the restart')
        tab.go('shift')
        names[kill] = stop_of(tab, 'node not running', names.values())
        classify(tab, names[kill], 'CLEANING')
        standing = stop_of(tab, 'stands', names.values())
        classify(tab, standing, 'SENSOR')  # while it stands
        names[-kill] = standing
        picture(tab, f'kill_{kill}')
        tab.go('overview')
        resume.first.click()
        tab.confirm('cell.resume', 'looked at everything')
    tab.go('shift')
    classify(tab, names[1], 'JAM')  # the last one counts
    cell.watch.until('job.completed', job='WO-1')

    report = plant.report()
    codes = {stop['stop']: stop['code'] for stop in report['line_stops']}
    expected = {1: 'JAM', 2: 'CLEANING', -1: 'SENSOR', -2: 'SENSOR'}
    assert {kill: codes[name] for kill, name in names.items()} == expected
    of_hold = [stop['code'] for stop in report['line_stops'] if stop['hold'] == '1']
    assert of_hold == ['GRIPPER']
    assert tab.data('twice') == '0'


@pytest.mark.parametrize(('locale', 'width'), [('en-GB', 1280), ('de-DE', 390)])
def test_single_press_pauses_and_reason_follows(
    sound_plant: Plant, start_page: StartPage, sit: Sit, locale: str, width: int
) -> None:
    """A reason of the plant needs no words, and counts from the press on."""
    cell = sound_plant.cell
    tab = sit(
        start_page(*sound_plant.page_options).port,
        locale=locale,
        viewport={'width': width, 'height': 844},
    ).open()
    tab.until_news()
    tab.log_in('engineer')
    cell.watch.submit('inspect_and_assemble', quantity=3)
    cell.watch.until('task.started', section=1)
    tab.page.locator('header [data-offer="cell.pause"]').click()
    tab.until(lambda: tab.count('dialog[data-dialog="reason-afterwards"]'), 'the question')
    cell.watch.until('hold.raised', reason='paused')
    picture(tab, f'afterwards_{width}')
    tab.page.locator('dialog [data-do="send"]').click()
    tab.until(lambda: tab.count('dialog .field-warning:visible'), 'that a reason is missing')
    choose(tab, 'reason-afterwards', 'LUNCH')
    tab.confirm('reason-afterwards', '')
    released = cell.watch.until('operator.decided', answer='resume')
    assert released['code'] == 'LUNCH'
    tab.until(lambda: tab.count('[data-hold]') == 1, 'the pause with a reason')
    tab.page.locator('header [data-offer="cell.resume"]').click()
    tab.confirm('cell.resume', 'lunch is over')
    cell.watch.until('job.completed', job='WO-1')

    pauses = [stop for stop in sound_plant.report()['line_stops'] if stop['loss'] == 'operator']
    pauses = [stop for stop in pauses if stop['hold']]
    assert {stop['code'] for stop in pauses} == {'LUNCH'}
    assert pauses[0]['hold'] == released['hold']
    assert tab.too_wide() == 0


@pytest.mark.long
def test_the_screen_of_stops_is_in_german(plant: Plant, start_page: StartPage, sit: Sit) -> None:
    cell = plant.cell
    tab = sit(start_page(*plant.page_options).port, locale='de-DE').open()
    tab.until_news()
    cell.watch.submit('inspect_and_assemble', quantity=1)
    tab.until(lambda: tab.count('[data-hold]'), 'the hold of component_3a')
    tab.log_in('engineer')
    tab.go('shift')
    stop = stop_of(tab, 'dauert an')
    tab.page.locator(f'[data-stop="{stop}"]').click()
    options = tab.page.locator('dialog select[name="code"] option').all_inner_texts()
    assert 'Materialstau' in options
    assert 'Mittagspause' in options
    choose(tab, 'stop.classify', 'JAM')
    picture(tab, 'german_form')
    tab.confirm('stop.classify', '')
    shown = tab.page.locator('.stops [data-code="JAM"]')
    tab.until(shown.count, 'the reason')
    assert shown.first.inner_text() == 'Materialstau'
    assert tab.too_wide() == 0
    picture(tab, 'german')
