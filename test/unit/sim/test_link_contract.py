"""The contract of doors, on a virtual engine in virtual time."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from contract.link_bench import LinkBench, folder_with_files
from contract.link_contract import LinkContract
from fakes.action_types import FakeActionTypes

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.events import Event
from bt_orchestrator.ports import CellLink
from bt_orchestrator.script.cell_file import read_cell
from bt_orchestrator.sim.virtual_link import VirtualLink, VirtualNode
from bt_orchestrator.store.memory import MemoryStore
from bt_orchestrator.store.sqlite.store import SqliteStore

TYPES = FakeActionTypes()


class LossyLink(VirtualLink):
    """Hears less than the node says."""

    def __init__(self, node: VirtualNode) -> None:
        super().__init__(node)
        self.is_lost: Callable[[Event], bool] = lambda _: False

    def hear(self, history: str, event: Event) -> None:
        if not self.is_lost(event):
            super().hear(history, event)


class VirtualBench:
    def __init__(self, folder: Path) -> None:
        self._file, self.journal = folder_with_files(folder)
        self._node = VirtualNode(self.cell(), TYPES, [folder])
        self._store: SqliteStore | None = None
        self.start(self.journal)

    @property
    def is_on(self) -> bool:
        return self._node.is_on

    def cell(self) -> Cell:
        return read_cell(self._file, TYPES)

    def link(self, timeout_s: float = 10.0) -> CellLink:
        return LossyLink(self._node)

    def lose(self, link: CellLink, is_lost: Callable[[Event], bool]) -> None:
        assert isinstance(link, LossyLink)
        link.is_lost = is_lost

    def kill(self) -> None:
        self._node.switch_off()
        if self._store is not None:
            self._store.close()

    def stop(self) -> None:
        self.kill()

    def start(self, journal: Path | None) -> None:
        self._store = None if journal is None else SqliteStore(journal)
        self._node.switch_on(self._store or MemoryStore())

    def close(self) -> None:
        if self.is_on:
            self.kill()


class TestVirtualLink(LinkContract):
    @staticmethod
    def make_bench(folder: Path) -> LinkBench:
        return VirtualBench(folder)
