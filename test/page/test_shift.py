"""A shift at the page, as people work it; a picture of each step.

With SHIFT_PICTURES=FOLDER the pictures stay in that folder.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from cell_processes import CellProcesses
from fakes.shipped import REFERENCE_CELL, TREES
from page.browsing import Person, Tab
from page.conftest import Sit, StartPage

from bt_orchestrator.model.keeping.records import Wanted
from bt_orchestrator.store.sqlite.records import SqliteRecords
from bt_orchestrator.view.report.reading import Reading

SCRIPT = 'inspect_and_assemble'
JOBS = {'WO-1': 6, 'WO-2': 3, 'WO-3': 2}
"""Orders, and how many pieces of each."""


JOURNAL = 'journal.sqlite3'


class Shift:
    """A tab of somebody at work, and a folder for its pictures."""

    def __init__(
        self,
        cell: CellProcesses,
        open_late: Callable[[], Tab],
        person: Person,
        tab: Tab,
        folder: Path,
    ) -> None:
        """Take what is there.

        :param open_late: opens a page that is started only then
        """
        self.cell = cell
        self.open_late = open_late
        self.person = person
        self.tab = tab
        self._folder = folder
        self._pictures = 0
        folder.mkdir(parents=True, exist_ok=True)

    def picture(self, name: str) -> None:
        """Keep what stands in the window now."""
        self.tab.until_quiet()
        self._pictures += 1
        self.tab.page.screenshot(path=self._folder / f'{self._pictures:02}_{name}.png')

    def until(self, selector: str, count: int = 1) -> None:
        """Wait until there are so many elements."""
        self.tab.until(lambda: self.tab.count(selector) == count, f'{count} {selector}')

    def until_state(self, state: str) -> None:
        """Wait until the bar on top says a state of the cell."""
        self.until(f'[data-part="cell"][data-state="{state}"]')

    def recorded(self, *names: str) -> list[Any]:
        """Return the events of these names in the journal."""
        journal = self.cell.folder.parent / JOURNAL
        with closing(SqliteRecords(journal)) as records:
            return list(Reading(records).events(Wanted(events=names)))

    def press(self, request: str, reason: str, within: str = 'header') -> None:
        """Ask for something by its button and dialog."""
        self.tab.page.locator(f'{within} [data-offer="{request}"]').first.click()
        self.tab.confirm(request, reason)

    def press_at_once(self, request: str, reason: str) -> None:
        """Press a button that does not ask before, and give the reason afterwards."""
        self.tab.page.locator(f'header [data-offer="{request}"]').click()
        self.tab.confirm('reason-afterwards', reason)


@pytest.fixture
def shift(tmp_path: Path, start_page: StartPage, sit: Sit) -> Iterator[Shift]:
    """Give a shift at the reference cell, whose component_3a fails at its first task."""
    cell = CellProcesses(
        tmp_path / 'cell',
        REFERENCE_CELL.read_text(),
        fail=['component_3a.TASK_A#1=abort'],
        speed=4,
        sim_options=['--result-timeout', '600'],
        run_options=[
            '--trust-local-doors',
            '--journal',
            str(tmp_path / JOURNAL),
            '--trees',
            str(TREES),
        ],
    )
    try:
        cell.connect()
        options = ('--journal', str(tmp_path / JOURNAL), '--trees', str(TREES))
        person = sit(start_page(*options).port, viewport={'width': 1280, 'height': 800})
        pictures = os.environ.get('SHIFT_PICTURES')
        tab = person.open()
        tab.until_news()
        folder = Path(pictures) if pictures else tmp_path / 'pictures'
        yield Shift(cell, lambda: sit(start_page(*options).port).open(), person, tab, folder)
    finally:
        cell.close()


@pytest.mark.long
def test_a_shift(shift: Shift) -> None:
    shift.picture('nothing_to_do')
    shift.tab.log_in('engineer')
    three_orders(shift)
    the_last_one_first(shift)
    a_task_that_failed(shift)
    abort_and_clear(shift)
    a_node_that_was_killed(shift)
    what_has_been(shift)


def three_orders(shift: Shift) -> None:
    tab = shift.tab
    tab.go('order')
    for order, quantity in JOBS.items():
        form = tab.page.locator('form.order-form')
        form.locator('[name="script"]').select_option(SCRIPT)
        form.locator('[name="quantity"]').fill(str(quantity))
        form.locator('[name="order"]').fill(order)
        tab.until_quiet()
        shift.picture(f'order_{order}')
        form.locator('[data-do="order"]').click()
        tab.confirm('queue.add', 'planned for today')
    tab.until(lambda: len(shift.recorded('job.queued')) == len(JOBS), 'the orders on record')


def the_last_one_first(shift: Shift) -> None:
    tab = shift.tab
    tab.go('queue')
    tab.page.locator('[data-job="WO-3"] [data-offer="job.next"]').click()
    shift.until('dialog [data-what-if="known"]')
    shift.picture('what_if')
    tab.confirm('job.next', 'the truck waits for it')
    shift.until('[data-job="WO-3"][data-position="1"]')
    shift.picture('queue')


def a_task_that_failed(shift: Shift) -> None:
    tab = shift.tab
    tab.go('overview')
    shift.until('[data-hold]')
    shift.until_state('Held')
    shift.picture('held')
    tab.page.locator('[data-hold] [data-offer="hold.retry"]').click()
    shift.picture('answer')
    tab.confirm('hold.retry', 'the part was turned')
    shift.until_state('Execute')
    shift.picture('goes_on')


def abort_and_clear(shift: Shift) -> None:
    tab = shift.tab
    tab.page.locator('header [data-offer="cell.abort"]').click()
    shift.until('dialog[data-dialog="reason-afterwards"]')
    shift.picture('abort')
    tab.confirm('reason-afterwards', 'a glove on the belt')
    shift.until_state('Aborted')
    shift.picture('aborted')
    tab.page.locator('header [data-offer="cell.clear"]').click()
    shift.picture('clear')
    tab.confirm('cell.clear', 'the belt is as it is shown')
    shift.until_state('Stopped')
    while tab.count('[data-hold]'):
        hold = tab.page.locator('[data-hold]').first.get_attribute('data-hold')
        tab.answer(hold, 'retry', 'looked at it')
        shift.until(f'[data-hold="{hold}"]', 0)
    shift.press('cell.reset', 'the glove is away')
    shift.until_state('Idle')
    shift.press('cell.start', 'go on')
    shift.until_state('Execute')
    shift.picture('works_again')


def a_node_that_was_killed(shift: Shift) -> None:
    tab = shift.tab
    shift.cell.node.kill()
    tab.until_news('node')
    shift.picture('node_silent')
    late = shift.open_late()
    late.until(
        lambda: late.count('[data-part="journal"] tbody tr') == 3, 'the jobs of the journal'
    )
    shift.cell.start_node()
    shift.cell.node.wait_ready()
    tab.until_news()
    shift.until('[data-hold]')
    shift.picture('restarted')
    shift.press('cell.resume', 'looked at everything', 'main [data-hold]')
    shift.until_state('Execute')
    tab.until(lambda: len(shift.recorded('job.completed')) == len(JOBS), 'the ends of the jobs')
    assert shift.person.loaded == 1


def what_has_been(shift: Shift) -> None:
    for screen in (
        'overview',
        'queue',
        'jobs',
        'job/WO-3',
        'item/WO-3/1',
        'section/4',
        'component/component_3a',
        'why',
        'tree',
    ):
        shift.tab.go(screen)
        shift.picture(screen.replace('/', '_'))
    decisions = (
        event
        for event in shift.recorded('operator.decided', 'operator.refused')
        if event.who == 'engineer'
    )
    assert list(dict.fromkeys(event.reason for event in decisions if event.reason)) == [
        'planned for today',
        'the truck waits for it',
        'the part was turned',
        'a glove on the belt',
        'the belt is as it is shown',
        'looked at it',
        'the glove is away',
        'go on',
        'looked at everything',
    ]
