"""What the last version left, in use: its journal is taken over, its users and programs work."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

from cell_processes import ROOT, StartCell
from page_process import PageProcess
from served_process import PASSWORD

KEPT = ROOT / 'test' / 'data' / 'release_0_1_0'

SAID = """\
role mes
cell reference_cell
API-1 True
API-2 True
cancel True
WO-2001 completed 4
WO-2001/1 packed ['pick', 'place', 'fill', 'weigh', 'mark', 'seal', 'pack']
events 5
"""


def test_node_takes_over_and_page_client_continues(start_cell: StartCell, tmp_path: Path) -> None:
    shutil.unpack_archive(KEPT / 'journal.tar.gz', tmp_path)
    journal = str(tmp_path / 'journal' / 'cell.db')
    text = (KEPT / 'cell.yaml').read_text(encoding='utf-8')
    options = ('--journal', journal, '--trees', str(KEPT / 'trees'), '--trust-local-doors')
    cell = start_cell(text, run_options=options)
    cell.connect()
    jobs = {job.id: (job.state, job.packed) for job in cell.watch.status.jobs}
    assert jobs['WO-3001'] == ('Interrupted', 3)
    assert jobs['WO-3002'] == ('NotAllowedToStart', 0)
    assert jobs['WO-2001'] == ('Ended', 4)
    holds = {hold.reason: hold for hold in cell.watch.status.holds}
    assert holds['aborted'].task == 'seal'
    assert holds['paused'].owner == 'Ann'
    shutil.copy(KEPT / 'users.yaml', tmp_path / 'users.yaml')
    (tmp_path / 'users.yaml').chmod(0o600)
    page = PageProcess(tmp_path, '/bt_orchestrator', ['--journal', journal])
    try:
        page.wait_heard()
        program = [sys.executable, str(KEPT / 'programs' / 'page_client.py')]
        done = subprocess.run(
            [*program, f'http://127.0.0.1:{page.port}', 'mes', 'inspect_by_weight'],
            env={**os.environ, 'PAGE_PASSWORD': PASSWORD},
            capture_output=True,
            text=True,
            check=False,
            timeout=90,
        )
        assert (done.stdout, done.returncode) == (SAID, 0), done.stderr
    finally:
        page.close()
