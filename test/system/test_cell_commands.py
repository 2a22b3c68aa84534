"""The cell is stopped, aborted, cleared and started again, on real action servers."""

from __future__ import annotations

import pytest
from cell_processes import CellProcesses, StartCell, run_verb
from worker_state import SAYS_NOTHING, WorkerState


@pytest.fixture
def manual_cell(start_cell: StartCell) -> CellProcesses:
    """Give the small cell, which starts only when it is told to."""
    cell = start_cell(run_options=['--no-auto-start'])
    cell.connect()
    return cell


def test_7_2_abort_clear_reset_start_and_the_job_finishes(manual_cell: CellProcesses) -> None:
    cell, watch = manual_cell, manual_cell.watch
    cell.run_small(task='TASK_B', quantity=2)
    early = watch.command('start')
    assert (early.accepted, early.state) == (False, 'Stopped')
    assert early.message.endswith('possible now: reset, pause, resume, abort')
    assert watch.command('reset').state == 'Idle'
    assert watch.command('start').state == 'Execute'
    watch.ros.spin_until(lambda: cell.goals(event='started', component='worker'), 'the long goal')
    watch.until('item.placed', item='WO-1/2')

    status, output, errors = run_verb(
        cell.folder, 'cell', 'abort', '--reason', 'smoke', '--who', 'Ada'
    )
    assert (status, errors) == (0, ''), output
    watch.until('cell.state_changed', state='Aborted')
    snapshot = watch.until_state('Aborted')
    (cancelled,) = watch.seen('task.cancel_requested', cause='abort')
    assert cell.goals(event='cancel', goal=cancelled['goal'], obeyed=True)
    (hold,) = snapshot.holds
    assert (hold.task, hold.item, hold.reason) == ('work', 'WO-1/1', 'in_doubt')
    assert (snapshot.stop_reason, snapshot.stop_message) == (
        'emergency',
        'somebody who claims to be Ada: smoke',
    )
    (decided,) = watch.seen('operator.decided', answer='abort')
    assert decided['origin'].startswith('bt-orchestrator at ')

    partial = watch.command('clear', belt=['2=empty'])
    assert partial.message.endswith('the cell believes 1=WO-1/2,2=WO-1/1')
    cleared = watch.command('clear', belt=['1=WO-1/2', '2=empty'])
    assert (cleared.accepted, cleared.state) == (True, 'Stopped'), cleared.message
    assert watch.until('item.removed', how='by_hand')['item'] == 'WO-1/1'
    assert not watch.answer(hold.id, 'retry').accepted, 'there is nothing to work on any more'
    assert watch.answer(hold.id, 'skip').accepted
    assert watch.until_state('Stopped').jobs[0].missing == 1
    assert watch.command('reset').accepted
    assert watch.command('start').accepted
    watch.until('task.started', task='work', item='WO-1/2')
    assert watch.command('stop').state == 'Stopping', 'the long goal still runs'
    assert watch.command('abort').accepted
    watch.until_state('Aborted')
    (hold,) = (h for h in watch.status.holds if h.task == 'work')
    assert watch.answer(hold.id, 'mark_done').accepted
    seen = watch.until_status(lambda s: not s.holds, 'no hold')
    status, output, errors = run_verb(
        cell.folder, 'cell', 'clear', '--as-shown', str(seen.seq), '--reason', 'looked'
    )
    assert (status, errors) == (0, ''), output
    assert watch.command('reset').accepted
    assert watch.command('start').accepted
    job = watch.until_ended('WO-1')
    assert (job.packed, job.missing) == (1, 1)
    times = {entry.state: entry.seconds for entry in watch.status.state_times}
    assert times['Execute'] > 0
    watch.assert_gapless()
    cell.stop()


def test_7_3_pauses_of_two_operators_are_released_separately(small_cell: CellProcesses) -> None:
    watch, folder = small_cell.watch, small_cell.folder
    for who in ('Ada', 'Bob'):
        assert watch.command('pause', who=who).accepted
    small_cell.run_small()
    watch.until_state('Held')
    assert [hold.owner for hold in watch.status.holds] == ['Ada', 'Bob']
    status, _, errors = run_verb(folder, 'cell', 'resume', '--who', 'Cat', '--reason', 'x')
    assert status == 1
    assert 'no pause is yours' in errors
    assert run_verb(folder, 'cell', 'resume', '--who', 'Ada', '--reason', 'x')[0] == 0
    assert not watch.seen('task.started')
    assert run_verb(folder, 'cell', 'resume', '--who', 'Cat', '--all', '--reason', 'x')[0] == 0
    assert watch.until_ended('WO-1').packed == 1
    small_cell.stop()


def test_7_2_cell_suspends_while_sink_is_not_ready(start_cell: StartCell) -> None:
    cell = start_cell(fail=[SAYS_NOTHING])
    cell.connect()
    state = WorkerState(cell)
    cell.run_small()
    status = cell.watch.until_state('Suspended')
    assert status.stop_reason == 'blocked'
    assert status.jobs[0].state == 'Interrupted'
    state.be_ready()
    assert cell.watch.until_ended('WO-1').packed == 1
    cell.stop()
