"""A cell in virtual time that is paced in real time, and doors to it for several threads."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from typing import Any

from fakes.action_types import FakeActionTypes
from fakes.line import Line, expanded
from fakes.operator import engineer
from fakes.shipped import REFERENCE_CELL, TREES

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.jobs.order import WorkOrder
from bt_orchestrator.model.requests import Asked, ask
from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.ports import CellLink, EventStore, Listener
from bt_orchestrator.script.cell_file import read_cell
from bt_orchestrator.sim.faults import with_faults
from bt_orchestrator.sim.virtual_link import VirtualLink, VirtualNode
from bt_orchestrator.store.memory import MemoryStore

TYPES = FakeActionTypes()

FAIL = 'component_3a.TASK_A#3=abort'
"""The fault of the reference cell unless another one is named: a hold, after some seconds."""

LONG_FAIL = 'a4.TASK_A#3=abort'
"""The same of a long line."""

PACE_S = 0.02
"""Real seconds between two moments of the cell."""

LATE_S = 0.2
"""Real seconds that the cell makes up for in one moment. On a busy machine it becomes slower:
if it jumped, nobody would see what was in between."""


class StandCell:
    """A virtual node that lives in real time. All use of it is under one lock."""

    def __init__(
        self,
        folder: Path,
        store: EventStore,
        *,
        sections: int = 5,
        faults: Sequence[str] | None = None,
        speed: float = 1.0,
    ) -> None:
        """Switch the cell on.

        :param folder: for the script of a long line
        :param sections: 5 is the reference cell; others are made up
        :param faults: COMPONENT.FAULT; None: one that gives a hold
        """
        self.lock = threading.RLock()
        self.speed = speed
        self.cell, self.script = _reference() if sections == 5 else _long(sections, folder)
        if faults is None:
            faults = [FAIL if sections == 5 else LONG_FAIL]
        self.cell = with_faults(self.cell, faults, TYPES)
        self.node = VirtualNode(self.cell, TYPES, [TREES, folder], start_s=time.time())
        self.store = store
        self.node.switch_on(store)
        self._passed_at = time.monotonic()

    def queue(self, *orders: WorkOrder) -> Answer:
        """Queue orders."""
        by = engineer('Ann', 'the stand', 'to have something to show')
        return self.ask(ask('queue.add', by, orders=list(orders)))

    def ask(self, asked: Asked) -> Answer:
        """Ask the cell for something."""
        with self.lock:
            link = VirtualLink(self.node)
            try:
                return link.ask(asked)
            finally:
                link.close()

    def open_door(self, meanwhile: Callable[[], object]) -> AbstractContextManager[CellLink]:
        """Open a door, for one thread (`web.seams.OpenDoor`)."""
        del meanwhile  # nothing here waits
        return _opened(self)

    def switch(self) -> None:
        """Kill the node, or start it again with the same journal."""
        with self.lock:
            if self.node.is_on:
                self.node.switch_off()
            else:
                self.node.switch_on(self.store)

    def begin_anew(self, cell: Cell) -> None:
        """Start the node again with another journal, which is empty, and with this cell file."""
        with self.lock:
            self.node.switch_off()
            self.node.cell = self.cell = cell
            self.store = MemoryStore()
            self.node.switch_on(self.store)

    def catch_up(self, turn: Callable[[float], None]) -> None:
        """Let as much time pass as really has, in small steps."""
        now = time.monotonic()
        passed_s, self._passed_at = min(now - self._passed_at, LATE_S), now
        turn(passed_s * self.speed)


class LockedLink:
    """A door for one thread of several. Implements `ports.CellLink`."""

    def __init__(self, stand: StandCell) -> None:
        self._stand = stand
        with stand.lock:
            self._link = VirtualLink(stand.node)

    @property
    def name(self) -> str:
        """Name of the node."""
        return self._link.name

    @property
    def silent_s(self) -> float:
        """For how long the node has been off, real seconds."""
        return self._link.silent_s / self._stand.speed

    def follow(self, listener: Listener, after_seq: int | None = None, history: str = '') -> None:
        """Follow the cell; its time passes in the turns of this door."""
        with self._stand.lock:
            self._link.follow(_Quieter(listener), after_seq, history)

    def turn(self, within_s: float) -> None:
        """Wait for a moment, and let the cell do what it did in it."""
        time.sleep(min(within_s, PACE_S))  # the pace of the cell, not a wait for something
        with self._stand.lock:
            self._stand.catch_up(self._link.turn)

    def __getattr__(self, name: str) -> Any:
        """Carry out everything else under the lock."""
        method = getattr(self._link, name)

        def locked(*args: Any) -> Any:
            with self._stand.lock:
                return method(*args)

        return locked


class _Quieter:
    """Passes a status on when something has happened, or a second is over, as a real node does."""

    def __init__(self, listener: Listener) -> None:
        self._status: CellStatus | None = None
        self._listener = listener
        self.on_event = listener.on_event
        self.on_gap = listener.on_gap
        self.on_history = listener.on_history

    def on_status(self, status: CellStatus) -> None:
        last = self._status
        if last is None or last.seq != status.seq or status.stamp - last.stamp >= 1.0:
            self._status = status
            self._listener.on_status(status)


@contextmanager
def _opened(stand: StandCell) -> Iterator[CellLink]:
    link: Any = LockedLink(stand)
    try:
        yield link
    finally:
        link.close()


def _reference() -> tuple[Cell, str]:
    return read_cell(REFERENCE_CELL, TYPES), 'inspect_and_assemble'


def _long(sections: int, folder: Path) -> tuple[Cell, str]:
    """Write the script of a long line, and return its cell and name."""
    line = Line(sections, topics=('a3',))
    first = '[{id: pick, @b1, requires_conveyor: false}, {id: place, @a1, qty_change: 1}]'
    tasks = ['sections:', f'  1: {first}']
    for n in range(2, sections):
        group = f'parallel: [{{id: weld{n}, @a{n}}}, {{id: watch{n}, @b{n}.TASK_B}}]'
        tasks.append(f'  {n}: [{{id: work{n}, @a{n}}}, {{{group}}}]')
    tasks.append(f'  {sections}: [{{id: pack, @a{sections}, qty_change: -1, runs_for: all}}]')
    name = f'line_of_{sections}'
    (folder / f'{name}.yaml').write_text(expanded('\n'.join([f'script: {name}', *tasks])))
    return line.cell, name
