"""A component is taken out of service on a running line, and the node is killed meanwhile."""

from __future__ import annotations

from pathlib import Path

from cell_processes import StartCell, run_verb


def test_7_5_component_out_of_service_gets_no_goal(start_cell: StartCell, tmp_path: Path) -> None:
    options = ['--journal', str(tmp_path / 'journal.db'), '--auto-resume']
    # Late by 6 s: the goal still runs when the component goes out of service.
    cell = start_cell(run_options=options, fail=['worker.TASK_C#1=late:120'])
    cell.connect()
    watch = cell.watch
    cell.run_small(task='TASK_C', quantity=2)
    watch.ros.spin_until(lambda: cell.goals(event='started', component='worker'), 'the long goal')

    answer = watch.command('out_of_service', component='worker', who='Ada')
    assert answer.accepted, answer.message
    assert 'work of WO-1/1 runs there and goes on to its end' in answer.message
    assert 'WO-1 on the line needs worker and waits' in answer.message
    cell.run_small(order='WO-2')
    watch.until('task.succeeded', task='work', item='WO-1/1')

    for name, why in (('worke', 'did you mean `worker`?'), ('worker', 'out of service already')):
        status, _, errors = run_verb(
            cell.folder, 'component', 'out-of-service', name, '--reason', 'worn'
        )
        assert status == 1
        assert why in errors

    cell.kill_and_restart_node()
    snapshot = watch.until_status(
        lambda shown: any(
            wait.kind == 'out_of_service' for part in shown.sections for wait in part.waits
        ),
        'a wait for the worker',
    )
    (worker,) = (shown for shown in snapshot.components if shown.name == 'worker')
    assert not worker.ready
    assert 'Ada: test' in worker.out_of_service
    (second,) = (job for job in snapshot.jobs if job.id == 'WO-2')
    assert (second.state, list(second.unavailable)) == ('NotAllowedToStart', ['worker'])
    assert len(cell.goals(event='started', component='worker')) == 1
    status, output, _ = run_verb(cell.folder, 'status')
    assert 'worker: out of service' in output
    status, output, _ = run_verb(cell.folder, 'queue')
    assert 'needs worker, out of service' in output

    assert run_verb(cell.folder, 'component', 'in-service', 'worker', '--reason', 'mended')[0] == 0
    assert watch.until_ended('WO-1').packed == 2
    assert watch.until_ended('WO-2').packed == 1
    cell.stop()
