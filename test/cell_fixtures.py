"""Fixtures: cells that run in processes of their own."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import program_process
import pytest
from cell_processes import SMALL_CELL, CellProcesses, StartCell
from failed_cells import CELLS
from loaded_program import CHILDREN_BY_PYTHON, LoadedProgram
from ros_domain import discovering_fast


@pytest.fixture(scope='session', autouse=True)
def fast_discovery() -> Iterator[None]:
    """Let processes find each other in tenths of a second instead of up to three seconds."""
    with discovering_fast():
        yield


@pytest.fixture(scope='session', autouse=True)
def loaded() -> Iterator[None]:
    """Let the program begin loaded; a process that runs tests of several folders loads it once."""
    if program_process.loaded is not None:
        yield
        return
    with closing(LoadedProgram()) as program, pytest.MonkeyPatch.context() as patch:
        patch.setattr(program_process, 'loaded', program)
        yield


@pytest.fixture
def children_by_python(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let Python start each process of a node, which then has a command line of its own."""
    monkeypatch.setenv(CHILDREN_BY_PYTHON, 'yes')


@pytest.fixture
def start_cell(tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[StartCell]:
    """Give a function that starts a cell."""
    started: list[CellProcesses] = request.node.stash.setdefault(CELLS, [])

    def start(*args: Any, folder: str = 'cell', **options: Any) -> CellProcesses:
        started.append(CellProcesses(tmp_path / folder, *args, **options))
        return started[-1]

    yield start
    for cell in started:
        cell.close()


@pytest.fixture
def small_cell(start_cell: StartCell) -> CellProcesses:
    """Give the small cell, connected."""
    cell = start_cell()
    cell.connect()
    return cell


@pytest.fixture
def small_cell_file(tmp_path: Path) -> Path:
    """Give the file of the small cell, of which nothing runs."""
    path = tmp_path / 'cell.yaml'
    path.write_text(SMALL_CELL)
    return path
