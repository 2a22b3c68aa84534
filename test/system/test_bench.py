"""The benchmarks run at all; what they say is another matter, for a quiet machine."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import pytest
from patience import PATIENCE_S, until
from process_use import family

ROOT = Path(__file__).parents[2]
CHEAP = ('simulator', 'sections', 'check', 'restart', 'report', 'postgres_append')


def test_the_cheap_rows_can_be_measured(tmp_path: Path) -> None:
    file, plot = tmp_path / 'rows.json', tmp_path / 'plot.svg'
    only = [word for key in CHEAP for word in ('--only', key)]
    words = ['--quick', *only, '--json', str(file), '--svg', str(plot)]
    output = run('bench', words, tmp_path)
    rows = json.loads(file.read_text())['rows']
    assert len(rows) == len(CHEAP)
    assert all(row['value'] > 0 and row['rounds'] for row in rows)
    assert plot.read_text().startswith('<?xml')
    assert all(row['name'] in output for row in rows)


def test_a_large_line_can_be_run(tmp_path: Path) -> None:
    words = ['--sections', '3', '--components', '6', '--items', '2', '--processes', '2']
    output = run('bench.scale', words, tmp_path)
    assert '16 goals in' in output
    assert 'ms CPU a goal' in output


@pytest.mark.parametrize('row', ['idle', 'dispatch'])
def test_a_bench_that_is_stopped_leaves_no_process(tmp_path: Path, row: str) -> None:
    bench = subprocess.Popen(
        [sys.executable, '-m', 'bench', '--quick', '--only', row],
        env=environment(),
        cwd=tmp_path,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    begun = {bench.pid}
    try:
        until(lambda: len(family(bench.pid)) > 2, 'servers and a driver')
        begun |= family(bench.pid)
        bench.terminate()
        assert bench.wait(PATIENCE_S) != 0
        until(lambda: not any(Path(f'/proc/{pid}').exists() for pid in begun), 'their end')
    finally:
        for pid in begun:
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)


def environment() -> dict[str, str]:
    """Return the environment in which the programs are found."""
    return {**os.environ, 'PYTHONPATH': os.pathsep.join([str(ROOT), str(ROOT / 'test')])}


def run(module: str, words: Sequence[str], folder: Path) -> str:
    """Return what one of the programs says."""
    done = subprocess.run(
        [sys.executable, '-m', module, *words],
        env=environment(),
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=80,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout
