"""A program that begins loaded is like one that Python has started."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import program_process
import pytest
from cell_processes import SMALL_CELL
from loaded_program import LoadedProgram
from patience import until
from process_use import family
from program_process import ProgramProcess


@pytest.fixture(scope='module')
def loaded() -> Iterator[LoadedProgram]:
    """Give what starts it."""
    with closing(LoadedProgram()) as program:
        yield program


def carried_out(words: list[str], folder: Path) -> tuple[int, str, str]:
    """Carry out a command line; return its exit status and what it printed."""
    process = ProgramProcess(words, folder, 'verb')
    return process.wait(), process.output, process.errors


@pytest.mark.parametrize('words', [['--version'], ['check', 'nowhere.yaml'], ['chekc']])
def test_it_says_the_same_and_ends_alike(
    words: list[str], loaded: LoadedProgram, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    by_python = carried_out(words, tmp_path)
    monkeypatch.setattr(program_process, 'loaded', loaded)
    assert carried_out(words, tmp_path) == by_python


@pytest.mark.parametrize(('number', 'status'), [(signal.SIGINT, 0), (signal.SIGKILL, -9)])
def test_ros_node_has_own_session_and_obeys_signal(
    number: signal.Signals,
    status: int,
    loaded: LoadedProgram,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    (tmp_path / 'cell.yaml').write_text(SMALL_CELL)
    monkeypatch.setattr(program_process, 'loaded', loaded)
    process = ProgramProcess(['sim-cell', '--cell', 'cell.yaml'], tmp_path, 'sim')
    process.wait_ready()
    assert process.is_running
    assert os.getsid(process.pid) == process.pid
    assert process.stop(number) == status
    process.assert_clean()


def test_node_forks_processes_that_end_with_it(
    loaded: LoadedProgram, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / 'cell.yaml').write_text(SMALL_CELL)
    monkeypatch.setattr(program_process, 'loaded', loaded)
    node = ProgramProcess(['run', '--cell', 'cell.yaml'], tmp_path, 'node')
    node.wait_ready()
    until(lambda: len(family(node.pid)) == 4, 'what forks, forecasts and orders')
    others = family(node.pid) - {node.pid}
    node.kill()
    until(lambda: not any(Path(f'/proc/{pid}').exists() for pid in others), 'their end')
