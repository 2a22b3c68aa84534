"""Local and remote of a real line: a node, a page at which people log in, and clients over ROS."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from cell_processes import CellProcesses, StartCell, run_verb, small_script
from page_process import Browser, PageProcess

from bt_orchestrator.script.users.file import UsersFile


@pytest.fixture
def page(tmp_path: Path) -> Iterator[PageProcess]:
    process = PageProcess(tmp_path, '/bt_orchestrator')
    yield process
    process.close()


def line_of(start_cell: StartCell, folder: Path, *options: str) -> CellProcesses:
    trusting = ['--trust-local-doors', '--users', str(folder / 'users.yaml')]
    return start_cell(run_options=[*trusting, *options])


def test_7_8_panel_takes_and_returns_control_across_kills(
    start_cell: StartCell, page: PageProcess, tmp_path: Path
) -> None:
    cell = line_of(
        start_cell, tmp_path, '--journal', str(tmp_path / 'journal.db'), '--auto-resume'
    )
    cell.connect()
    page.wait_heard()
    cell.script(small_script())
    local = ('cell', 'local', '--reason', 'work at section 2')
    status, _, errors = run_verb(cell.folder, *local)
    assert (status, 'there is no panel in' in errors) == (1, True), errors

    users = UsersFile(page.users)
    users.change_panel('user', 'operate', named=True)
    status, output, errors = run_verb(cell.folder, *local)
    assert (status, 'the line is in local' in output) == (0, True), errors

    status, _, errors = run_verb(cell.folder, 'cell', 'reset', '--reason', 'why not')
    assert (status, 'cell.reset moves the line, which is in local' in errors) == (1, True)
    order = cell.folder / 'order.yaml'
    order.write_text('order: WO-1\nscript: small\nquantity: 1\n')
    status, output, errors = run_verb(cell.folder, 'submit', str(order))
    assert (status, 'a panel has to release' in output) == (0, True), output + errors

    cell.kill_and_restart_node()
    restored = cell.watch.until_status(lambda view: view.control == 'local', 'local after a kill')
    assert restored.state == 'Stopped'
    status, output, _ = run_verb(cell.folder, 'status')
    assert 'in local: only the panels of the line move it' in output

    with closing(Browser(page.port, 'engineer')) as elsewhere:
        refused = elsewhere.ask('job.release', job='WO-1')
        assert 'engineer (page login) is at none' in refused['message']
    with closing(Browser(page.port, 'operate')) as panel:
        assert panel.ask('job.release', job='WO-1')['accepted']
        assert cell.watch.until_ended('WO-1').packed == 1
        assert panel.ask('cell.remote')['accepted']
        assert panel.ask('cell.local')['accepted']
    decided = cell.watch.until('operator.decided', answer='remote')
    assert (decided['who'], decided['known']) == ('operate', 'page panel')

    users.change_panel('user', 'operate', named=False)
    cell.node.kill()
    cell.start_node(options=['--control', 'remote'])
    cell.node.wait_ready()
    cell.watch.until_status(lambda view: view.control == 'remote', 'remote by the option')
    cell.stop()
