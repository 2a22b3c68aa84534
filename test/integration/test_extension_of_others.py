"""The extension of docs/examples, installed as a package of its own: its verb and its format."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from fakes.shipped import REFERENCE_CELL

from bt_orchestrator.store.sqlite.store import SqliteStore

EXAMPLE = Path(__file__).parents[2] / 'docs' / 'examples' / 'extension'


@pytest.fixture(scope='module')
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Give the folder into which it is installed, without a network."""
    folder = tmp_path_factory.mktemp('extension')
    shutil.copytree(EXAMPLE, folder / 'source')
    options = ['--no-index', '--no-deps', '--no-build-isolation', '-q', '--target']
    command = [sys.executable, '-m', 'pip', 'install', *options, 'at', './source']
    subprocess.run(command, check=True, timeout=120, cwd=folder)
    return folder / 'at'


def program(installed: Path, folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join(filter(None, [str(installed), os.environ.get('PYTHONPATH', '')]))
    return subprocess.run(
        [sys.executable, '-m', 'bt_orchestrator', *words],
        env={**os.environ, 'PYTHONPATH': path},
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )


def test_its_verb_and_its_format(installed: Path, tmp_path: Path) -> None:
    SqliteStore(tmp_path / 'journal.db').close()
    words = ('--journal', 'journal.db', '--format', 'names', '-o', 'names.txt')
    written = program(installed, tmp_path, 'events', *words)
    assert (written.returncode, written.stderr) == (0, '')
    (tmp_path / 'names.txt').write_text('job.queued\nitem.moved\nitem.moved\n')
    counted = program(installed, tmp_path, 'count-events', 'names.txt')
    assert counted.stdout.split() == ['2', 'item.moved', '1', 'job.queued'], counted.stderr


def test_its_output_hears_the_events_of_a_node(installed: Path, tmp_path: Path) -> None:
    command = [sys.executable, '-m', 'bt_orchestrator', 'run', '--cell', str(REFERENCE_CELL)]
    path = os.pathsep.join(filter(None, [str(installed), os.environ.get('PYTHONPATH', '')]))
    environment = {**os.environ, 'PYTHONPATH': path, 'ROS_LOG_DIR': str(tmp_path / 'log')}
    node = subprocess.Popen([*command, '--sink', 'last-event'], cwd=tmp_path, env=environment)
    try:
        deadline = time.monotonic() + 60
        while not (heard := tmp_path / 'last_event.txt').exists():
            assert node.poll() is None
            assert time.monotonic() < deadline
            time.sleep(0.05)
    finally:
        node.send_signal(signal.SIGINT)
        node.wait(60)
    assert heard.read_text()


def test_without_it_nobody_knows_them(tmp_path: Path) -> None:
    nowhere = tmp_path / 'nowhere'
    assert "found 'count-events'" in program(nowhere, tmp_path, 'count-events', 'x').stderr
    refused = program(nowhere, tmp_path, 'events', '--journal', 'x', '--format', 'names')
    assert refused.returncode == 2
    unknown = program(nowhere, tmp_path, 'run', '--sink', 'last-event').stderr
    assert 'run: no installed package brings the output last-event' in unknown
    assert 'names' in refused.stderr
