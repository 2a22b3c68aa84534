"""The contract of doors, on a real tree node in another process."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from contract.link_bench import LinkBench, folder_with_files
from contract.link_contract import LinkContract
from program_process import ProgramProcess
from ros_domain import discovering_fast

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.events import Event
from bt_orchestrator.ports import CellLink
from bt_orchestrator.ros.link.ros_link import RosLink, event_of
from bt_orchestrator.ros.types.action_types import InstalledActionTypes
from bt_orchestrator.script.cell_file import read_cell

pytestmark = pytest.mark.every_distro

NODE = '/bt_orchestrator'


class LossyLink(RosLink):
    """Hears less than the node says."""

    is_lost: Callable[[Event], bool] = staticmethod(lambda _: False)

    def _on_event(self, message: Any) -> None:
        if not self.is_lost(event_of(message)):
            super()._on_event(message)


class RosBench:
    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._domain = os.environ['ROS_DOMAIN_ID']
        self._file, self.journal = folder_with_files(folder)
        self._sim = ProgramProcess(['sim-cell', '--cell', str(self._file)], folder, 'sim')
        self._node: ProgramProcess | None = None
        self.start(self.journal)
        self._sim.wait_ready()

    @property
    def is_on(self) -> bool:
        return self._node is not None

    def cell(self) -> Cell:
        return read_cell(self._file, InstalledActionTypes())

    def link(self, timeout_s: float = 10.0) -> CellLink:
        with self._in_domain():
            return LossyLink(NODE, timeout_s)

    def lose(self, link: CellLink, is_lost: Callable[[Event], bool]) -> None:
        assert isinstance(link, LossyLink)
        link.is_lost = is_lost

    def kill(self) -> None:
        assert self._node is not None
        self._node.kill()
        self._node = None

    def stop(self) -> None:
        assert self._node is not None
        assert self._node.stop() == 0, self._node.errors
        self._node.assert_clean()
        self._node = None

    def start(self, journal: Path | None) -> None:
        kept = [] if journal is None else ['--journal', str(journal), '--auto-resume']
        words = ['run', '--cell', str(self._file), '--trees', str(self._folder), *kept]
        with self._in_domain():
            self._node = ProgramProcess(words, self._folder, 'node')
        self._node.wait_ready()

    @contextmanager
    def _in_domain(self) -> Iterator[None]:
        """Let what begins here meet what began with the bench: each test has another domain."""
        with pytest.MonkeyPatch.context() as patch:
            patch.setenv('ROS_DOMAIN_ID', self._domain)
            yield

    def close(self) -> None:
        for process in (self._node, self._sim):
            if process is not None:
                process.kill()


class TestRosLink(LinkContract):
    @staticmethod
    def make_bench(folder: Path) -> LinkBench:
        return RosBench(folder)

    @pytest.fixture(scope='class', autouse=True)
    @staticmethod
    def fast_discovery() -> Iterator[None]:
        with discovering_fast():
            yield
