"""Fixtures of the system tests: cells that run in processes of their own."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from cell_processes import CellProcesses

StartCell = Callable[..., CellProcesses]


@pytest.fixture
def start_cell(tmp_path: Path) -> Iterator[StartCell]:
    """Give a function that starts a cell; its arguments are those of `CellProcesses`."""
    started: list[CellProcesses] = []

    def start(*args: object, folder: str = 'cell', **options: object) -> CellProcesses:
        started.append(CellProcesses(tmp_path / folder, *args, **options))  # type: ignore[arg-type]
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
