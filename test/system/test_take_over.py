"""A killed orchestrator goes on where it was, on real action servers (semantics 9)."""

from __future__ import annotations

import random
import time
from collections import Counter
from pathlib import Path

from cell_processes import SMALL_CELL, CellProcesses, StartCell, remembering
from program_process import ProgramProcess

from bt_orchestrator.model import events as e
from bt_orchestrator.store.sqlite.store import SqliteStore

ITEMS = 6
KILLS = 4


def journal(cell: CellProcesses) -> list[e.Event]:
    """Return what the journal says; the node must be gone."""
    store = SqliteStore(cell.folder / 'journal.sqlite3')
    events = list(store.read())
    store.close()
    return events


def start(start_cell: StartCell, tmp_path: Path, *options: str) -> CellProcesses:
    path = tmp_path / 'cell' / 'journal.sqlite3'
    cell = start_cell(remembering(SMALL_CELL), run_options=['--journal', str(path), *options])
    cell.connect()
    return cell


def until_some_goal_ran(cell: CellProcesses, goals: int) -> None:
    cell.watch.ros.spin_until(lambda: len(cell.goals(event='started')) >= goals, 'goals to run')


def test_9_2_repeated_kills_execute_every_task_once(start_cell: StartCell, tmp_path: Path) -> None:
    cell = start(start_cell, tmp_path, '--auto-resume')
    drawn = random.Random(9)
    cell.run_small(task='TASK_C', quantity=ITEMS)  # two seconds of real time each
    for kill in range(1, KILLS + 1):
        until_some_goal_ran(cell, 4 * kill)
        moment = time.monotonic() + drawn.random() * 0.5
        cell.watch.ros.spin_until(lambda until=moment: time.monotonic() > until, 'a moment')  # type: ignore[misc]
        cell.kill_and_restart_node()
    cell.watch.until_ended('WO-1', within_s=60.0)
    cell.stop()

    events = journal(cell)
    done = Counter((x.item, x.task) for x in events if isinstance(x, e.TaskSucceeded))
    ran = Counter(record['goal'] for record in cell.goals(event='started'))
    assert [x.seq for x in events] == list(range(1, len(events) + 1))
    assert sum(isinstance(x, e.OrchestratorStarted) for x in events) == KILLS + 1
    assert any(isinstance(x, e.TaskAdopted) for x in events)
    assert not [x for x in events if isinstance(x, e.TaskFailed)]
    for number in range(1, ITEMS + 1):
        for task in ('feed', 'work', 'pack'):
            assert done[f'WO-1/{number}', task] == 1
    assert set(ran.values()) == {1}
    assert ran.total() == done.total(), 'the controllers executed what the journal says, no more'


def test_9_2_restart_without_auto_resume_holds_and_reports(
    start_cell: StartCell, tmp_path: Path
) -> None:
    cell = start(start_cell, tmp_path)
    cell.run_small(task='TASK_C')
    until_some_goal_ran(cell, 3)
    cell.kill_and_restart_node()

    hold = cell.watch.until_held()
    assert (hold.reason, list(hold.answers)) == ('restarted', ['resume'])
    assert hold.message == 'unfinished jobs: 1, goals in flight: 1'
    plain = ('resume', '--all', '--reason', 'back', '--who', 'Ann', '--timeout', '20')
    refused = ProgramProcess(plain, cell.folder, 'verb_resume_all')
    assert refused.wait() == 1
    assert f'resume --hold {hold.id} --reason WHY' in refused.errors
    verb = ('cell', 'resume', '--hold', hold.id, '--reason', 'looked at it', '--who', 'Ann')
    resumed = ProgramProcess(verb, cell.folder, 'verb_resume')
    assert resumed.wait() == 0, resumed.errors
    cell.watch.until_ended('WO-1')
    cell.stop()


def test_9_1_a_second_orchestrator_is_kept_out(start_cell: StartCell, tmp_path: Path) -> None:
    cell = start(start_cell, tmp_path)
    path = str(tmp_path / 'cell' / 'journal.sqlite3')
    second = ProgramProcess(
        ['run', '--cell', str(cell.cell), '--journal', path, '--namespace', 'other'],
        cell.folder,
        'second',
    )
    assert second.wait() == 1
    assert 'is in use by another orchestrator' in second.errors
    cell.stop()
