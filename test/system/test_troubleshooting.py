"""Every command of docs/troubleshooting.md, run beside a cell that is held and paused."""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path

import pytest
from cell_processes import ROOT, StartCell, run_verb
from patience import PATIENCE_S
from program_process import program_in

PAGE = ROOT / 'docs' / 'troubleshooting.md'


def commands() -> list[str]:
    """Return the lines of all blocks, each once, in the order of the page."""
    text = PAGE.read_text(encoding='utf-8')
    blocks = re.findall(r'^```sh\n(.*?)^```$', text, re.MULTILINE | re.DOTALL)
    return list(dict.fromkeys(''.join(blocks).splitlines()))


def test_every_entry_has_symptom_cause_and_command() -> None:
    entries = PAGE.read_text(encoding='utf-8').split('\n## ')[1:]
    assert len(entries) >= 8
    for entry in entries:
        for part in ('\n**Symptom.** ', '\n**Cause.** ', '\n**Command.**', '\n```sh\n'):
            assert entry.count(part) == 1, (entry.partition('\n')[0], part)


@pytest.mark.long
@pytest.mark.timeout(600)
def test_every_command_does_what_it_is_for(start_cell: StartCell, tmp_path: Path) -> None:
    journal = ['--journal', str(tmp_path / 'cell' / 'journal.db')]
    cell = start_cell(fail=['worker.#1=abort'], run_options=journal)
    cell.connect()
    cell.run_small()
    cell.watch.until('hold.raised')
    for reason in ('as of a twin', 'as after a restart'):  # holds 2 and 3, as on the page
        assert run_verb(cell.folder, 'cell', 'pause', '--reason', reason)[0] == 0

    path = f'{program_in(tmp_path / "bin")}:{os.environ["PATH"]}'
    (tmp_path / 'cell' / 'trees').mkdir()
    script = (tmp_path / 'cell' / 'small.yaml').read_text()
    drains = script.replace('qty_change: -1', 'qty_change: -1, runs_for: all')
    (tmp_path / 'cell' / 'trees' / 'small.yaml').write_text(drains)
    printed = ''
    for command in commands():
        done = subprocess.run(
            ['sh', '-c', command],
            cwd=cell.folder,
            env={**os.environ, 'PATH': path},
            capture_output=True,
            text=True,
            timeout=PATIENCE_S,
            check=False,
        )
        assert (done.returncode, done.stderr) == (0, ''), f'{command}\n{done.stdout}{done.stderr}'
        printed += done.stdout

    assert 'hold 1: section 2, work (TASK_A) of WO-1/1 at' in printed
    assert f'\n{cell.node.pid}\n' in printed, 'who has the journal'
    assert 'ok    worker: state topic: /worker/state (/sim_cell)' in printed
    assert 'ok    tree node: /bt_orchestrator runs' in printed
    cell.watch.until_ended('WO-1')
    cell.stop()
