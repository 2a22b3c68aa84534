"""The operator page of a real node: what its stream tells while the node comes and goes."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any, cast
from urllib.request import urlopen

import pytest
from cell_processes import StartCell
from page_process import PageProcess
from patience import PATIENCE_S
from web.sse_client import Message, SseClient

from bt_orchestrator.cli.journal_file import open_records
from bt_orchestrator.cli.numbers import moment
from bt_orchestrator.view.report.account.account import account
from bt_orchestrator.view.report.account.period import Period
from bt_orchestrator.view.report.account.plain import account_plain
from bt_orchestrator.view.report.reading import Reading as RecordsReading


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
        updates = [message for message in self.messages if message.kind == 'happened']
        return [record['seq'] for message in updates for record in message.data['records']]

    def all(self, kind: str) -> list[Message]:
        """Return the messages of a kind so far."""
        return [message for message in self.messages if message.kind == kind]

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
    shifts = tmp_path / 'shifts.yaml'
    shifts.write_text('shifts: {day: {from: 00:00, to: 00:00}}')
    process = PageProcess(tmp_path, '/bt_orchestrator', ['--shifts', str(shifts)])
    yield process
    process.close()


def shift_of(page: PageProcess) -> dict[str, Any]:
    """Return the account of the shift that runs."""
    url = f'http://127.0.0.1:{page.port}/api/shift'
    with urlopen(url, timeout=PATIENCE_S) as answer:
        return cast('dict[str, Any]', json.load(answer))


def test_page_delivers_each_event_once_despite_kills(
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
    with closing(open_records(journal)) as records:
        last = records.extent().last_seq
        cell.watch.ros.spin_until(lambda: reading.seqs[-1:] == [last], 'the last event is told')
        cell.watch.ros.spin_until(lambda: shift_of(page)['quantities']['good'] == 12, 'the shift')
        shift = shift_of(page)
        since, until = (round(moment(shift['period'][name]) * 1e6) for name in ('from', 'to'))
        made = account(RecordsReading(records), Period.all_planned('', since, until), None)
    assert shift['losses'] == account_plain(made)['losses']
    assert shift['losses']['no_node'] > 0

    page.stop()  # although somebody reads, who would never end by himself
    reading.join()
    (begin,) = reading.all('begin')
    assert reading.seqs == list(range(begin.data['after'] + 1, last + 1))
    assert not reading.all('gap')


def test_page_begins_anew_with_another_journal(start_cell: StartCell, page: PageProcess) -> None:
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
