"""Who is told what is heard of the cell, and when."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable
from contextlib import closing
from pathlib import Path

import pytest
from fakes.opcua_access import any_security
from web.stand_cell import StandCell

from bt_orchestrator.base.errors import NodeUnreachable
from bt_orchestrator.extensions.opcua.server.bridge import Bridge
from bt_orchestrator.extensions.opcua.server.overrides.server import GuardedServer
from bt_orchestrator.extensions.opcua.server.values import Values
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.jobs.order import WorkOrder
from bt_orchestrator.model.status import CellDescription, CellStatus
from bt_orchestrator.ports.doors.following_door import Began, Fact, Happened
from bt_orchestrator.sim.virtual_link import VirtualLink
from bt_orchestrator.store.memory import MemoryStore


class Listening:
    """A part that takes notes."""

    def __init__(self, *, is_defect: bool = False) -> None:
        self.told: list[object] = []
        self._is_defect = is_defect

    async def build(self, space: object) -> None:
        """Make nothing."""

    def show(self, status: CellStatus) -> None:
        """Take note."""
        self.told.append(f'status {status.seq}')
        if self._is_defect:
            raise ValueError('a defect of this part')

    def hear(self, event: Event) -> None:
        """Take note."""
        self.told.append(event.seq)
        if self._is_defect:
            raise ValueError('a defect of this part')

    def begin(self, history: str) -> None:
        """Take note."""
        self.told.append(history)


class Scene:
    """Facts of a cell, and a bridge that is told them."""

    def __init__(self, folder: Path) -> None:
        self.cell = StandCell(folder, MemoryStore(), faults=[])
        self.bridge = Bridge(self.cell.node.name, self.cell.open_door)
        self.tell = self.bridge._take

    def happen(self, order: str) -> list[Fact]:
        """Queue an order; return what is to be told of it, the status last."""
        before = self.status().seq
        assert self.cell.queue(WorkOrder(self.cell.script, order, 1)).accepted
        return [*map(Happened, self.cell.store.read(before)), self.status()]

    def status(self) -> CellStatus:
        with closing(VirtualLink(self.cell.node)) as link:
            return link.status()


def bridged(folder: Path, what: Callable[[Scene, Values], Awaitable[None]]) -> None:
    async def done() -> None:
        scene = Scene(folder)
        await what(scene, Values(GuardedServer(any_security('/node'))))

    asyncio.run(done())


def begun(scene: Scene) -> list[Fact]:
    status = scene.status()
    return [Began(status.history, status.seq), status]


def started(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the bridge know the cell, without its threads."""
    monkeypatch.setattr(scene.bridge, 'doors', _Heard(), raising=False)
    scene.tell(begun(scene))


class _Heard:
    """Doors that are heard, and cannot be asked."""

    is_silent = False

    async def description(self) -> CellDescription:
        raise NodeUnreachable('nobody is asked here')


def test_new_parts_receive_events_missed_during_build(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    async def look(scene: Scene, values: Values) -> None:
        started(scene, monkeypatch)
        before = scene.bridge.status
        scene.bridge.hold_back()
        facts = scene.happen('WO-1')
        scene.tell(facts)
        assert scene.bridge.status is before
        part = Listening()
        scene.bridge.serve([part], values)
        seqs = [fact.event.seq for fact in facts if isinstance(fact, Happened)]
        assert seqs == list(range(before.seq + 1, scene.status().seq + 1))
        assert part.told == [f'status {before.seq}', *seqs, f'status {scene.status().seq}']

    bridged(tmp_path, look)


def test_defective_part_does_not_silence_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    async def look(scene: Scene, values: Values) -> None:
        started(scene, monkeypatch)
        good = Listening()
        scene.bridge.serve([Listening(is_defect=True), good], values)
        scene.tell(scene.happen('WO-1'))
        assert good.told[-1] == f'status {scene.status().seq}'
        assert len(good.told) > 2

    with caplog.at_level(logging.ERROR):
        bridged(tmp_path, look)
    assert 'defect: a part of the server could not take' in caplog.text
