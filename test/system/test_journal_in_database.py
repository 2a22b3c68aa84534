"""A node whose journal is in PostgreSQL, which is slow, or away, or has it already (9.1)."""

from __future__ import annotations

import os
import time
from collections import Counter

import pytest
from bt_orchestrator_interfaces.srv import GetEvents, QueueList
from cell_processes import SMALL_CELL, CellProcesses, StartCell, remembering
from postgres_proxy import through
from postgres_server import PostgresServer, kept_events
from program_process import ProgramProcess

from bt_orchestrator.model import events as e


def start(start_cell: StartCell, address: str, *options: str) -> CellProcesses:
    cell = start_cell(remembering(SMALL_CELL), run_options=['--journal', address, *options])
    cell.connect()
    return cell


def until_some_goal_ran(cell: CellProcesses, goals: int) -> None:
    cell.watch.ros.spin_until(lambda: len(cell.goals(event='started')) >= goals, 'goals to run')


def test_9_1_node_ends_without_database_and_next_continues(
    start_cell: StartCell, server: PostgresServer, address: str
) -> None:
    cell = start(start_cell, address, '--auto-resume')
    cell.run_small(task='TASK_C', quantity=2)
    until_some_goal_ran(cell, 2)
    server.stop()
    try:
        assert cell.node.wait() == os.EX_TEMPFAIL, cell.node.errors
        assert 'cannot be written' in cell.node.errors
        assert 'Traceback' not in cell.node.errors
        cell.start_node()
        assert cell.node.wait() == 1
        assert 'cannot be reached' in cell.node.errors
    finally:
        server.start()
    cell.start_node()
    cell.node.wait_ready()
    cell.watch.until_ended('WO-1', within_s=60.0)
    cell.stop()
    ran = Counter(record['goal'] for record in cell.goals(event='started'))
    assert set(ran.values()) == {1}
    assert not [x for x in kept_events(address) if isinstance(x, e.TaskFailed)]


SLOW_S = 0.4
"""How long a slow database takes for each statement that reads: an answer needs three."""

AT_ONCE_S = 0.8
"""A node that waits for no reading answers within this time."""


def test_9_1_slow_database_delays_readers_but_not_line(
    start_cell: StartCell, server: PostgresServer, address: str
) -> None:
    with through(address, server.folder) as (place, proxy):
        cell = start(start_cell, place)
        cell.run_small(quantity=2)
        cell.watch.until_ended('WO-1')
        proxy.slow_reading_s = SLOW_S
        began = time.monotonic()
        pages = [
            cell.watch.begin(GetEvents, 'get_events', GetEvents.Request(after_seq=after))
            for after in range(3)
        ]
        took = []
        while not pages[-1].done():
            asked = time.monotonic()
            assert cell.watch.call(QueueList, 'queue/list', QueueList.Request()).accepted
            took.append(time.monotonic() - asked)
        assert max(took) < AT_ONCE_S, f'{len(took)} answers'
        assert time.monotonic() - began > 3 * SLOW_S
        first = [message.seq for message in pages[0].result().events]
        assert first == list(range(1, len(first) + 1))
        assert all(page.result().last_seq >= len(first) for page in pages)
        cell.stop()


def test_9_1_journal_has_one_writer_and_many_readers(start_cell: StartCell, address: str) -> None:
    cell = start(start_cell, address)
    cell.run_small(quantity=2)
    cell.watch.until_ended('WO-1')
    words = ['run', '--cell', str(cell.cell), '--journal', address, '--namespace', 'other']
    second = ProgramProcess(words, cell.folder, 'second')
    assert second.wait() == 1
    assert 'in use by another orchestrator' in second.errors

    status, output, errors = cell.verb('history', '--journal', address)
    assert (status, errors) == (0, ''), errors
    assert 'WO-1' in output
    status, output, _ = cell.verb('events', '--journal', address, '--event', 'item.')
    assert status == 0
    assert output.count('"how": "packed"') == 2
    status, output, errors = cell.verb('report', '--journal', address, '--job', 'WO-1')
    assert status == 0, errors
    assert 'WO-1' in output
    cell.stop()


def test_9_1_a_password_in_an_address_is_refused(tmp_path_factory: pytest.TempPathFactory) -> None:
    folder = tmp_path_factory.mktemp('words')
    address = 'postgresql://plant:secret@host/plant/line_1'
    for words in (['run', '--journal', address], ['history', '--journal', address]):
        verb = ProgramProcess(words, folder, words[0])
        assert verb.wait() == 2
        assert '~/.pgpass' in verb.errors
        assert 'secret' not in verb.errors
