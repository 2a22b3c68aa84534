"""A disk that takes seconds: who only reads is served meanwhile, and an answer is on disk."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from bt_orchestrator_interfaces.srv import Command, GetEvents
from cell_processes import CellProcesses, StartCell
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from fakes.journal_reading import journal_reading
from py_trees_ros_interfaces.srv import OpenSnapshotStream
from rcl_interfaces.srv import GetParameters

from bt_orchestrator.model.keeping.records import Wanted


@contextmanager
def slow_disk(journal: Path) -> Iterator[None]:
    """Hold the lock that every commit needs: it then takes as long as this lasts."""
    other = sqlite3.connect(journal, isolation_level=None)
    other.execute('BEGIN IMMEDIATE')
    try:
        yield
    finally:
        other.execute('ROLLBACK')
        other.close()


def begin(cell: CellProcesses, command: str) -> Any:
    request = Command.Request(command=command, who='Ann', reason='a test')
    return cell.watch.begin(Command, 'command', request)


def on_disk(journal: Path, event: str) -> int:
    with journal_reading(journal) as reader:
        return len(list(reader.each(Wanted(events=(event,)))))


def start(start_cell: StartCell, journal: Path, *options: str) -> CellProcesses:
    cell = start_cell(run_options=['--journal', str(journal), *options])
    cell.connect()
    return cell


def heard(cell: CellProcesses) -> Callable[[], list[DiagnosticStatus]]:
    statuses: list[DiagnosticStatus] = []
    cell.watch.ros.node.create_subscription(
        DiagnosticArray, '/diagnostics', lambda message: statuses.extend(message.status), 10
    )
    return lambda: statuses


def test_9_1_readers_do_not_wait_for_disk(start_cell: StartCell, tmp_path: Path) -> None:
    journal = tmp_path / 'cell' / 'journal.sqlite3'
    cell = start(start_cell, journal)
    diagnostics = heard(cell)
    cell.run_small(task='TASK_B')
    started = cell.watch.until('task.started', task='work')['seq']
    kept = cell.watch.until_status(lambda s: s.seq >= started, 'the status of that').seq
    with slow_disk(journal):
        paused = begin(cell, 'pause')
        shown = cell.watch.until_status(lambda s: s.disk_wait, 'the wait for the disk')
        assert 'the disk has not taken the last' in shown.disk_wait
        assert shown.seq <= kept
        page = cell.watch.call(GetEvents, 'get_events', GetEvents.Request(after_seq=kept - 1))
        assert [message.seq for message in page.events] == [kept]
        assert page.last_seq == kept
        names = GetParameters.Request(names=['journal_timeout'])
        assert cell.watch.call(GetParameters, 'get_parameters', names).values[0].double_value == 15
        opened = cell.watch.call(
            OpenSnapshotStream, 'snapshot_streams/open', OpenSnapshotStream.Request()
        )
        assert opened.topic_name
        cell.watch.ros.spin_until(
            lambda: any(
                status.level == DiagnosticStatus.WARN and 'the disk has not' in status.message
                for status in diagnostics()
            ),
            'a warning in diagnostics',
        )
        again = begin(cell, 'resume')
        cell.watch.call(GetEvents, 'get_events', GetEvents.Request())
        assert not paused.done()
        assert not again.done()
    cell.watch.ros.spin_until(paused.done, 'the answer to pause')
    assert paused.result().accepted
    assert on_disk(journal, 'hold.raised') == 1
    cell.watch.ros.spin_until(again.done, 'the answer to resume')
    assert again.result().accepted
    assert not cell.watch.until_status(lambda s: not s.disk_wait, 'the end of the wait').disk_wait
    cell.stop()


def test_9_1_disk_timeout_is_reported_and_abort_cancels(
    start_cell: StartCell, tmp_path: Path
) -> None:
    journal = tmp_path / 'cell' / 'journal.sqlite3'
    cell = start(start_cell, journal, '--journal-timeout', '1')
    cell.run_small(task='TASK_B')
    goal = str(cell.watch.until('task.started', task='work')['goal'])
    cell.watch.ros.spin_until(lambda: cell.goals(event='started', goal=goal), 'the goal to run')
    with slow_disk(journal):
        aborted = begin(cell, 'abort')
        cell.watch.ros.spin_until(aborted.done, 'the answer to abort')
        assert aborted.result().accepted
        assert 'is being cancelled; this is not on record' in aborted.result().message
        shown = cell.watch.until_status(lambda s: s.journal_failure, 'the broken journal')
        assert 'within 1 s, and may take them still or not' in shown.journal_failure
        cell.watch.ros.spin_until(
            lambda: cell.goals(event='ended', goal=goal, status='canceled'), 'the cancelled goal'
        )
    cell.stop()
