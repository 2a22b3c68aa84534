"""`new-cell --from-graph` beside real action servers, each in a process of its own."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from cell_processes import run_verb
from fakes.shipped import REFERENCE_CELL
from program_process import ProgramProcess

from bt_orchestrator.ros.types.action_types import InstalledActionTypes
from bt_orchestrator.script.cell_file import read_cell


@pytest.fixture
def controllers(tmp_path: Path) -> Iterator[None]:
    """Simulate the shipped cell, in processes whose nodes have one name."""
    words = ['sim-cell', '--cell', str(REFERENCE_CELL), '--only']
    shares = (
        'conveyor,unpacking_arm',
        'component_1a,component_2a,component_3a',
        'component_3b,component_3c,packing_arm',
    )
    processes = [
        ProgramProcess([*words, share], tmp_path, f'controllers_{number}')
        for number, share in enumerate(shares)
    ]
    for process in processes:
        process.wait_ready()
    yield
    for process in processes:
        assert process.stop() == 0, process.errors


@pytest.mark.usefixtures('controllers')
def test_the_servers_that_run_are_filled_in(tmp_path: Path) -> None:
    folder = tmp_path / 'mine'
    words = ['new-cell', 'mine', '--sections', '5', '-o', str(folder), '--from-graph']
    status, output, errors = run_verb(tmp_path, *words, '--timeout', '20')
    assert (status, errors) == (0, '')
    assert '8 of 8 devices found on the ROS graph' in output

    types = InstalledActionTypes()
    new_cell = read_cell(folder / 'cell.yaml', types)
    real = read_cell(REFERENCE_CELL, types)
    assert {component.action: component.type for component in new_cell.components.values()} == {
        component.action: component.type for component in real.components.values()
    }
    assert new_cell.components['component_3c'].sections == (4,)
    assert '# state: {topic: /unpacking/state,' in (folder / 'cell.yaml').read_text()
    cell = ['--cell', str(folder / 'cell.yaml'), '--trees', str(folder / 'trees')]
    assert run_verb(tmp_path, 'check', 'first_product', *cell)[0] == 0
    order = str(folder / 'order.yaml')
    assert run_verb(tmp_path, 'simulate', order, *cell)[0] == 0


def test_without_servers_nothing_is_written(tmp_path: Path) -> None:
    words = ['new-cell', 'mine', '--sections', '2', '-o', str(tmp_path / 'mine'), '--from-graph']
    status, output, errors = run_verb(tmp_path, *words, '--timeout', '0.5')
    assert (status, output) == (1, '')
    assert 'no action server was found within 0.5 s; start the controllers' in errors
    assert not (tmp_path / 'mine').exists()
