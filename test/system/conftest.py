"""Fixtures of the system tests: cells that run in processes of their own."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from cell_processes import ROOT, SMALL_CELL, CellProcesses, StartCell

PROFILES = ('FASTDDS_DEFAULT_PROFILES_FILE', 'FASTRTPS_DEFAULT_PROFILES_FILE')
"""The second is Jazzy's name, of which Kilted warns."""


@pytest.fixture(scope='session', autouse=True)
def fast_discovery() -> Iterator[None]:
    """Let processes find each other in tenths of a second instead of up to three seconds."""
    is_jazzy = os.environ.get('ROS_DISTRO') == 'jazzy'
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(PROFILES[is_jazzy], str(ROOT / 'test' / 'data' / 'fast_discovery.xml'))
        yield


@pytest.fixture
def start_cell(tmp_path: Path) -> Iterator[StartCell]:
    """Give a function that starts a cell."""
    started: list[CellProcesses] = []

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
