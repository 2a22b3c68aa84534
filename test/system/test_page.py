"""The operator page of a real node: what its stream tells while the node comes and goes."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
from cell_processes import StartCell
from page_process import PageProcess
from program_process import PATIENCE_S
from web.sse_client import Message, SseClient

from bt_orchestrator.cli.journal_file import open_records


class Reading:
    """Reads a stream to its end in a thread, as a browser would."""

    def __init__(self, port: int) -> None:
        self.messages: list[Message] = []
        self._client = SseClient(port)
        self._thread = threading.Thread(target=self._read)
        self._thread.start()

    @property
    def seqs(self) -> list[int]:
        """Numbers of the events told so far."""
        told = [one for one in self.messages if one.kind == 'happened']
        return [record['seq'] for one in told for record in one.data['records']]

    def all(self, kind: str) -> list[Message]:
        """Return the messages of a kind so far."""
        return [one for one in self.messages if one.kind == kind]

    def join(self) -> None:
        """Wait for the end of the stream."""
        self._thread.join(PATIENCE_S)
        assert not self._thread.is_alive()
        self._client.close()

    def _read(self) -> None:
        while (message := self._client.next()) is not None:
            self.messages.append(message)


@pytest.fixture
def page(tmp_path: Path) -> Iterator[PageProcess]:
    found = PageProcess(tmp_path, '/bt_orchestrator')
    yield found
    found.close()


def test_each_event_is_told_once_although_the_node_is_killed(
    start_cell: StartCell, page: PageProcess, tmp_path: Path
) -> None:
    journal = tmp_path / 'journal.sqlite3'
    cell = start_cell(run_options=['--journal', str(journal), '--auto-resume'])
    cell.connect()
    page.wait_ready()
    reading = Reading(page.port)
    cell.watch.ros.spin_until(lambda: reading.all('begin'), 'the page has heard of the node')
    cell.run_small(quantity=12)
    for count in (2, 5):
        cell.watch.until('item.removed', count)
        cell.kill_and_restart_node()
        cell.watch.connect_anew()
    cell.watch.until_ended('WO-1')
    with_journal = open_records(journal)
    last = with_journal.extent().last_seq
    with_journal.close()
    cell.watch.ros.spin_until(lambda: reading.seqs[-1:] == [last], 'the last event is told')

    page.stop()  # although somebody reads, who would never end by himself
    reading.join()
    (begin,) = reading.all('begin')
    assert reading.seqs == list(range(begin.data['after'] + 1, last + 1))
    assert not reading.all('gap')


def test_a_node_that_comes_with_another_journal_begins_anew(
    start_cell: StartCell, page: PageProcess
) -> None:
    page.wait_ready()
    reading = Reading(page.port)
    cell = start_cell()  # the page was there first
    cell.connect()
    cell.watch.ros.spin_until(lambda: reading.all('begin'), 'the page has found the node')
    cell.kill_and_restart_node()
    cell.watch.connect_anew()
    cell.watch.ros.spin_until(lambda: len(reading.all('begin')) == 2, 'the page begins anew')
    cell.run_small()
    cell.watch.until_ended('WO-1')
    page.stop()
    reading.join()
    first, second = reading.all('begin')
    assert first.data['history'] != second.data['history']
