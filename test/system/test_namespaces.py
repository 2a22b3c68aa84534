"""Two cells side by side, and one cell spread over several processes."""

from __future__ import annotations

from cell_processes import StartCell


def test_cells_in_two_namespaces_are_isolated(start_cell: StartCell) -> None:
    cells = {name: start_cell(namespace=f'/{name}', folder=name) for name in ('a', 'b')}
    for cell in cells.values():
        cell.connect()
    for name, cell in cells.items():
        assert cell.node.wait_ready().startswith(f'tree node ready: /{name}/bt_orchestrator ')
        cell.run_small(quantity=4, order=f'WO-{name}')

    for name, cell in cells.items():
        assert cell.watch.until_ended(f'WO-{name}').packed == 4
        jobs = {event['job'] for event in cell.watch.events if 'job' in event}
        assert jobs == {f'WO-{name}'}
        started = {event['goal'] for event in cell.watch.seen('task.started')}
        assert {record['goal'] for record in cell.goals(event='started')} == started
    for cell in cells.values():
        cell.stop()


def test_fault_holds_only_its_own_cell(start_cell: StartCell) -> None:
    good = start_cell(namespace='/a', folder='a')
    bad = start_cell(namespace='/b', folder='b', fail=['worker.TASK_A=abort'])
    for cell in (good, bad):
        cell.connect()
        cell.run_small(quantity=2)

    assert bad.watch.until_held().reason == 'aborted'
    assert good.watch.until_ended('WO-1').packed == 2
    assert not good.watch.seen('hold.raised')
    for cell in (good, bad):
        cell.stop()


def test_components_of_cell_run_in_several_processes(start_cell: StartCell) -> None:
    cell = start_cell(shares=('conveyor', 'feeder,packer', 'worker'))
    cell.connect()
    cell.run_small(quantity=4)

    assert cell.watch.until_ended('WO-1').packed == 4
    assert [sim.wait_ready() for sim in cell.sims] == [
        'sim-cell ready: 1 action server',
        'sim-cell ready: 2 action servers',
        'sim-cell ready: 1 action server',
    ]
    cell.stop()
