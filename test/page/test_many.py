"""Many tabs, many readers, stuck ones among them, and a page that stands still."""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from functools import partial

import pytest
from cell_processes import STATELESS_CELL, CellProcesses, StartCell
from page.browsing import Tab
from page.conftest import Sit, StartPage
from process_use import memory_mb
from stream_readers import StreamReader, StuckReader

TABS = 12
READERS = 20
STUCK = 30
MORE_MB = 10.0
STANDS_STILL_S = 25.0


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    """Give what closes things at the end."""
    with ExitStack() as stack:
        yield stack


@pytest.mark.long
def test_twelve_tabs_are_live_and_last_answers_hold(
    start_cell: StartCell, start_page: StartPage, sit: Sit
) -> None:
    cell = start_cell(STATELESS_CELL, fail=['worker.TASK_A#1=abort'])
    cell.connect()
    page = start_page()
    person = sit(page.port)
    tabs = [person.open() for _ in range(TABS)]
    cell.run_small(quantity=2)
    hold = cell.watch.until_held()
    in_each(tabs, lambda tab: tab.count(f'[data-hold="{hold.id}"]'), 'the hold')
    in_each(tabs, lambda tab: tab.data('news') == 'fresh', 'fresh news')
    assert page.readers == 1
    last = tabs[-1]
    last.log_in('operate')
    last.answer(hold.id, 'retry', 'the part was turned')
    decided = cell.watch.until('operator.decided', hold=hold.id)
    assert (decided['who'], decided['answer']) == ('operate', 'retry')
    assert decided['reason'] == 'the part was turned'
    in_each(tabs, lambda tab: not tab.count('[data-hold]'), 'no hold')
    cell.watch.until_ended('WO-1')
    seq = cell.watch.status.seq
    in_each(tabs, lambda tab: tab.seq >= seq, f'event {seq}')


def in_each(tabs: Sequence[Tab], condition: Callable[[Tab], object], what: str) -> None:
    for tab in tabs:
        tab.until(partial(condition, tab), f'{what} in each tab')


@pytest.mark.long
def test_stuck_readers_cost_the_others_nothing(
    start_cell: StartCell, start_page: StartPage, stack: ExitStack
) -> None:
    cell = start_cell(STATELESS_CELL)
    cell.connect()
    page = start_page()
    readers = [StreamReader(page.port) for _ in range(READERS)]
    for reader in readers:
        stack.callback(reader.close)
        reader.wait_begun()
    cell.run_small(quantity=10_000)
    cell.watch.until('item.removed', count=5)
    heard = readers[0].numbers
    early, early_mb = len(heard), memory_mb(page.process.pid)
    cell.watch.until('item.removed', count=40)
    before, before_mb = len(heard), memory_mb(page.process.pid)
    # The page keeps the last events, whoever reads them.
    an_event_mb = (before_mb - early_mb) / (before - early)
    for _ in range(STUCK):
        stack.callback(StuckReader(page.port).close)
    most_mb = before_mb
    cell.watch.ros.spin_until(lambda: page.readers == READERS + STUCK, 'all readers')

    def all_stuck_are_gone() -> bool:
        nonlocal most_mb
        most_mb = max(most_mb, memory_mb(page.process.pid))
        return page.readers == READERS

    cell.watch.ros.spin_until(all_stuck_are_gone, 'all that are stuck to be sent away')
    assert most_mb - before_mb - an_event_mb * (len(heard) - before) <= MORE_MB
    cell.watch.command('stop')
    last = cell.watch.until_state('Stopped').seq
    cell.watch.ros.spin_until(lambda: all(r.last >= last for r in readers), f'event {last}')
    for reader in readers:
        assert reader.numbers == list(range(reader.numbers[0], reader.numbers[-1] + 1))
        assert reader.numbers == readers[0].numbers


@pytest.mark.long
def test_a_page_that_stands_still_changes_no_goal(
    start_cell: StartCell, start_page: StartPage
) -> None:
    with_page, without = (start_cell(STATELESS_CELL, folder=n, namespace=f'/{n}') for n in 'ab')
    for cell in (with_page, without):
        cell.connect()
    page = start_page(node='/a/bt_orchestrator')
    reader = StreamReader(page.port)
    reader.wait_begun()
    page.process.send(signal.SIGSTOP)
    stopped = time.monotonic()
    for cell in (with_page, without):
        cell.run_small(task='TASK_C', quantity=10)
    for cell in (with_page, without):
        cell.watch.until_ended('WO-1')
    left_s = max(STANDS_STILL_S - (time.monotonic() - stopped), 0.0)
    with_page.watch.ros.spin_for(left_s, lambda: False)
    page.process.send(signal.SIGCONT)
    assert done(with_page) == done(without)
    last = with_page.watch.status.seq
    with_page.watch.ros.spin_until(lambda: reader.last >= last, f'event {last}')
    reader.close()
    assert reader.numbers == list(range(reader.numbers[0], last + 1))


def done(cell: CellProcesses) -> dict[str, list[tuple[str, ...]]]:
    """Return what each component was told and did, in order."""
    steps: dict[str, list[tuple[str, ...]]] = {}
    for record in cell.goals():
        step = (record['event'], record.get('task', ''), record.get('status', ''))
        steps.setdefault(record['component'], []).append(step)
    return steps
