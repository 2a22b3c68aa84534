"""The journal of a real node: another one, a disk that is full, a backup."""

from __future__ import annotations

import json
import resource
from contextlib import closing
from functools import partial
from pathlib import Path

from bt_orchestrator_interfaces.srv import Command
from cell_processes import SMALL_CELL, CellProcesses, StartCell, remembering, run_verb
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from fakes.journal_reading import journal_reading
from fakes.other_python import back_up
from program_process import ProgramProcess

from bt_orchestrator.model.keeping.records import Wanted
from bt_orchestrator.store.sqlite.records import SqliteRecords
from bt_orchestrator.store.sqlite.store import SqliteStore

ROOM = 4096
"""Bytes of a file on a disk that is full: so much of the log beside a journal is long written."""


def start(start_cell: StartCell, path: Path) -> CellProcesses:
    options = ['--journal', str(path), '--auto-resume']
    cell = start_cell(remembering(SMALL_CELL), run_options=options)
    cell.connect()
    return cell


def told(follower: ProgramProcess, words: str) -> bool:
    return words in follower.output


def test_follower_continues_when_node_has_another_journal(
    small_cell: CellProcesses,
) -> None:
    words = ['events', '--since-seq', '0', '--timeout', '20']
    follower = ProgramProcess(words, small_cell.folder, 'events')
    ended: dict[str, int] = {}
    try:
        for order in ('WO-1', 'WO-2', 'WO-3'):
            small_cell.run_small(order=order)
            small_cell.watch.until_ended(order)
            ended[order] = small_cell.watch.until_state('Complete').seq
            done = f'"event": "job.completed", "job": "{order}"'
            small_cell.watch.ros.spin_until(partial(told, follower, done), f'the end of {order}')
            small_cell.kill_and_restart_node()  # without a journal: the next one counts from 1
        assert follower.stop() == 0
    finally:
        follower.kill()
    seqs = [json.loads(line)['seq'] for line in follower.output.splitlines()]
    expected = [seq for last in ended.values() for seq in range(1, last + 1)]
    assert seqs[: len(expected)] == expected
    assert follower.errors.count('the node has another journal') in (2, 3)
    small_cell.stop()


def test_full_disk_is_reported_and_restart_continues(
    start_cell: StartCell, tmp_path: Path
) -> None:
    path = tmp_path / 'cell' / 'journal.sqlite3'
    cell = start(start_cell, path)
    statuses: list[DiagnosticStatus] = []
    cell.watch.ros.node.create_subscription(
        DiagnosticArray, '/diagnostics', lambda message: statuses.extend(message.status), 10
    )
    cell.run_small(task='TASK_C', quantity=3)
    cell.watch.until('task.started', task='work')
    resource.prlimit(cell.node.pid, resource.RLIMIT_FSIZE, (ROOM, ROOM))

    status = cell.watch.until_status(lambda s: s.journal_failure, 'the failure of the journal')
    assert 'cannot be written' in status.journal_failure
    assert 'start the orchestrator again' in status.journal_failure
    cell.watch.ros.spin_until(
        lambda: any(s.level == DiagnosticStatus.ERROR for s in statuses), 'an error in diagnostics'
    )
    request = Command.Request(command='pause', who='Ann', reason='a test')
    refused = cell.watch.call(Command, 'command', request)
    assert (refused.accepted, refused.message) == (False, status.journal_failure)

    cell.kill_and_restart_node()
    cell.watch.until_ended('WO-1', within_s=40.0)
    ran = [record['goal'] for record in cell.goals(event='started')]
    assert len(ran) == len(set(ran))
    cell.stop()
    store = SqliteStore(path)
    last = max(event.seq for event in store.read())
    assert next(iter(store.snapshots())).seq == last  # for a quick start
    store.close()


def broken_at_work(start_cell: StartCell, path: Path) -> tuple[CellProcesses, str]:
    """Let a task of a minute run while the disk becomes full; returns its goal, too."""
    cell = start(start_cell, path)
    cell.run_small(task='TASK_B')
    goal = str(cell.watch.until('task.started', task='work')['goal'])
    cell.watch.ros.spin_until(lambda: cell.goals(event='started', goal=goal), 'the goal to run')
    resource.prlimit(cell.node.pid, resource.RLIMIT_FSIZE, (ROOM, ROOM))
    return cell, goal


def until_canceled(cell: CellProcesses, goal: str) -> None:
    cell.watch.ros.spin_until(
        lambda: cell.goals(event='ended', goal=goal, status='canceled'), 'the goal to be canceled'
    )


def test_9_1_abort_cancels_goals_on_a_full_disk(start_cell: StartCell, tmp_path: Path) -> None:
    cell, goal = broken_at_work(start_cell, tmp_path / 'cell' / 'journal.sqlite3')
    status, _, errors = cell.verb('cell', 'pause', '--reason', 'a visitor')
    assert status == 1
    assert 'cannot be written' in errors
    assert not cell.goals(event='cancel')

    status, output, errors = cell.verb('cell', 'abort', '--reason', 'smoke')
    assert status == 0, errors
    assert '1 goal is being cancelled; this is not on record' in output
    until_canceled(cell, goal)
    shown = cell.watch.until_status(
        lambda s: '1 asked to cancel without a record, 0 of them' in s.journal_failure, 'its end'
    )
    assert (shown.state, shown.stop_reason) == ('Held', 'own_fault')
    assert list(shown.commands) == ['abort']
    assert cell.verb('cell', 'pause', '--reason', 'a visitor')[0] == 1
    assert cell.verb('cell', 'abort', '--reason', 'to be sure')[0] == 0
    cell.stop()


def test_9_1_abort_discovering_full_disk_cancels_goals(
    start_cell: StartCell, tmp_path: Path
) -> None:
    cell, goal = broken_at_work(start_cell, tmp_path / 'cell' / 'journal.sqlite3')
    status, output, errors = cell.verb('cell', 'abort', '--reason', 'smoke')
    assert status == 0, errors
    assert 'this is not on record' in output
    until_canceled(cell, goal)
    cell.stop()


def test_9_1_node_stop_cancels_goals_on_full_disk(start_cell: StartCell, tmp_path: Path) -> None:
    cell, goal = broken_at_work(start_cell, tmp_path / 'cell' / 'journal.sqlite3')
    assert cell.verb('cell', 'pause', '--reason', 'a visitor')[0] == 1
    assert cell.node.stop() == 0, cell.node.errors
    assert cell.goals(event='ended', goal=goal, status='canceled')


def test_backup_changes_nothing_and_restores_with_hold(
    start_cell: StartCell, tmp_path: Path
) -> None:
    path = tmp_path / 'cell' / 'journal.sqlite3'
    cell = start(start_cell, path)
    cell.run_small(task='TASK_C', quantity=2)
    cell.watch.until('task.started', task='work')
    cell.kill_and_restart_node()  # the newest events are in the log now
    cell.watch.until('task.succeeded', task='work')
    copy = back_up(path)
    cell.watch.until_ended('WO-1')
    heard = cell.watch.until_state('Complete').seq
    cell.node.kill()
    with journal_reading(path) as reader:
        seqs = [seq for seq, _ in reader.each(Wanted())]
    assert seqs == list(range(1, len(seqs) + 1))
    assert len(seqs) >= heard

    words = ['journal', 'restore', str(copy), str(path), '--move-aside']
    status, output, errors = run_verb(cell.folder, *words)
    assert status == 0, errors
    assert f'the journal that was there is {path}.aside-' in output
    ran = len(cell.goals(event='started'))
    cell.start_node()  # with --auto-resume
    cell.node.wait_ready()
    held = cell.watch.until_status(
        lambda s: 'restored' in [hold.reason for hold in s.holds], 'the hold `restored`'
    )
    assert held.history != cell.watch.statuses[0].history
    assert len(cell.goals(event='started')) == ran
    cell.stop()


def test_a_report_still_has_what_retention_removed(start_cell: StartCell, tmp_path: Path) -> None:
    journal = tmp_path / 'cell.db'
    options = ['--journal', str(journal), '--journal-keep-jobs', '0']
    cell = start_cell(run_options=options)
    cell.connect()
    for number, order in enumerate(('WO-1', 'WO-2'), 1):
        cell.run_small(order=order, quantity=number)
        cell.watch.until_ended(order)
    last = cell.watch.until_state('Complete').seq
    cell.watch.ros.spin_until(partial(are_removed, journal, last), 'the end of retention')
    status, output, errors = run_verb(cell.folder, 'report', '--journal', str(journal), '--json')
    assert (status, errors) == (0, '')
    report = json.loads(output)
    assert [(job['job'], job['good']) for job in report['jobs']] == [('WO-1', 1), ('WO-2', 2)]
    assert report['made_from']['books']
    assert report['made_from']['removed_before_seq'] > 20
    assert report['losses'].keys().isdisjoint(['not_recorded'])
    cell.stop()


def are_removed(journal: Path, last: int) -> bool:
    """Tell whether all events of jobs are gone."""
    with closing(SqliteRecords(journal)) as records:
        return records.extent().first_seq > last - 20
