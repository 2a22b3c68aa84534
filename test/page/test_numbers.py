"""Whatever breaks, a tab takes in every event of the journal once, and is not loaded again."""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest
from cell_processes import STATELESS_CELL, CellProcesses, StartCell, remembering, run_verb
from page.browsing import Person, Tab
from page.conftest import Sit, StartPage, StartProxy
from page.proxy import LoseOneEvent, Proxy
from page_process import PageProcess

from bt_orchestrator.store.sqlite.records import SqliteRecords

TIMES = 3
MISSED = 20
"""Events that happen while something is broken, so that there is something to miss."""


class Line:
    """A line at work with a journal, its page, a wire to it, and a tab at the other end."""

    def __init__(
        self, cell: CellProcesses, page: PageProcess, wire: Proxy, person: Person
    ) -> None:
        self.cell = cell
        self.page = page
        self.wire = wire
        self.person = person
        self.tab: Tab = person.open()
        self.tab.until_news()

    @property
    def happened(self) -> int:
        """Number of the last event, by the journal: this process may hear of it much later."""
        with closing(SqliteRecords(self.journal)) as records:
            return records.extent().last_seq

    @property
    def journal(self) -> Path:
        """Of the node."""
        return self.cell.folder / 'journal.sqlite3'

    def until_shown(self) -> None:
        """Wait until the tab has what has happened by now."""
        happened = self.happened
        self.tab.until(lambda: self.tab.seq >= happened, f'event {happened}')

    def miss_something(self) -> None:
        """Wait until more has happened."""
        more = self.happened + MISSED
        self.tab.until(lambda: self.happened >= more, f'event {more}')

    def end(self) -> list[int]:
        """Stop the line, let the tab have the rest, and return the numbers in the journal."""
        self.cell.watch.command('stop')
        self.cell.watch.until_state('Stopped')
        self.until_shown()
        self.cell.stop()
        words = ['events', '--journal', str(self.journal)]
        status, output, errors = run_verb(self.cell.folder, *words)
        assert (status, errors) == (0, '')
        return [json.loads(line)['seq'] for line in output.splitlines()]


@pytest.fixture
def line(
    start_cell: StartCell, start_page: StartPage, start_proxy: StartProxy, sit: Sit, tmp_path: Path
) -> Line:
    """Give a line that has more to do than a test takes."""
    journal = tmp_path / 'cell' / 'journal.sqlite3'
    options = ['--journal', str(journal), '--auto-resume', '--journal-synchronous', 'NORMAL']
    # A node that was killed finds what its goals came to, however long it was away, and can prove
    # for a minute that a goal never arrived.
    long = ['--result-timeout', '600']
    cell = start_cell(remembering(STATELESS_CELL), sim_options=long, run_options=options)
    cell.connect()
    page = start_page()
    wire = start_proxy(page.port)
    line = Line(cell, page, wire, sit(wire.port))
    cell.run_small(quantity=10_000)
    line.until_shown()
    return line


def kill_node(line: Line) -> None:
    line.cell.node.kill()
    line.tab.until_news('node')
    line.cell.start_node()
    line.cell.node.wait_ready()


def kill_page(line: Line) -> None:
    line.page.process.kill()
    line.tab.until_news('page')
    line.miss_something()
    line.page.start()


def cut_the_wire(line: Line) -> None:
    line.wire.cut()
    line.miss_something()
    line.wire.mend()


def let_the_wire_go_silent(line: Line) -> None:
    line.wire.go_silent()
    line.tab.until_news('page')
    line.miss_something()
    line.wire.mend()


BREAKS: tuple[Callable[[Line], None], ...] = (
    kill_node,
    kill_page,
    cut_the_wire,
    let_the_wire_go_silent,
)


@pytest.mark.long
def test_every_event_comes_once_whatever_breaks(line: Line) -> None:
    first = line.tab.first
    for _ in range(TIMES):
        for breaks in BREAKS:
            breaks(line)
            line.tab.until_news()
            line.until_shown()
    journal = line.end()
    assert journal == list(range(1, journal[-1] + 1))
    assert line.tab.seen == journal[first - 1 :]
    assert line.tab.data('twice') == '0'
    assert line.person.loaded == 1


def test_one_lost_event_is_noticed(line: Line) -> None:
    lose = LoseOneEvent()
    line.wire.lose(lose)
    line.tab.until(lambda: lose.lost is not None, 'an event to be lost')
    line.miss_something()
    journal = line.end()
    assert set(journal[line.tab.first - 1 :]) - set(line.tab.seen) == {lose.lost}
