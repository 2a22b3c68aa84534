"""What the contract of doors needs of the world around a door."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Protocol

from bt_orchestrator.engine.runtime.recovery import restore, stamp
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.keeping.state_text import StateText
from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.ports import CellLink, Snapshot
from bt_orchestrator.store.sqlite.restoring import bring_back
from bt_orchestrator.store.sqlite.store import SqliteStore

CELL = """
cell: link_cell
conveyor:
  sections: 2
  action: /conveyor/index
  type: bt_orchestrator_interfaces/action/Conveyor
  task: MOVE_ONE_INDEX
components:
  feeder:
    {section: 1, action: /feeder/task, type: bt_orchestrator_interfaces/action/Component,
     durations: {TASK_A: 0.2}}
  breaker:
    {section: 2, action: /breaker/task, type: bt_orchestrator_interfaces/action/Component,
     durations: {TASK_A: 0.2}, faults: [=abort]}
"""
"""Its breaker aborts every goal."""

SCRIPT = """
script: small
params: {speed: {type: float, default: 1.0}}
sections:
  1: [{id: feed, task: TASK_A, action: /feeder/task, qty_change: 1}]
  2: [{id: break, task: TASK_A, action: /breaker/task, qty_change: -1}]
"""


class LinkBench(Protocol):
    """A node that can be killed, its journal, and doors to it."""

    def link(self, timeout_s: float = 10.0) -> CellLink:
        """Return a new door.

        :param timeout_s: longest time for an answer
        """

    def lose(self, link: CellLink, is_lost: Callable[[Event], bool]) -> None:
        """Let messages about events be lost on their way to a door from now on."""

    def kill(self) -> None:
        """End the node as kill -9 does."""

    def stop(self) -> None:
        """End the node as an operator of the computer does."""

    def start(self, journal: Path | None) -> None:
        """Start the node, which must be gone, and wait until it answers.

        :param journal: None: its events are kept in memory
        """

    @property
    def is_on(self) -> bool:
        """Tell whether the node runs."""

    @property
    def journal(self) -> Path:
        """The file of the journal that a bench begins with."""

    def cell(self) -> Cell:
        """Return the cell as the node reads it."""

    def close(self) -> None:
        """Put everything away."""


class Seen:
    """A listener that remembers everything."""

    def __init__(self) -> None:
        self.events: list[Event] = []
        self.status: CellStatus | None = None
        self.gaps: list[tuple[int, int]] = []
        self.histories: list[str] = []

    @property
    def seqs(self) -> list[int]:
        """Numbers of the events, since the last history began."""
        return [event.seq for event in self.events]

    def on_status(self, status: CellStatus) -> None:
        self.status = status

    def on_event(self, event: Event) -> None:
        self.events.append(event)

    def on_gap(self, first: int, last: int) -> None:
        self.gaps.append((first, last))

    def on_history(self, history: str) -> None:
        self.histories.append(history)
        self.events.clear()

    def of(self, name: str, **about: Any) -> list[Event]:
        """Return the events of a name with these values."""
        return [
            event
            for event in self.events
            if event.event == name and about.items() <= vars(event).items()
        ]


def folder_with_files(folder: Path) -> Sequence[Path]:
    """Write the files of a bench; returns cell file and journal."""
    (folder / 'small.yaml').write_text(SCRIPT)
    cell = folder / 'cell.yaml'
    cell.write_text(CELL)
    return cell, folder / 'journal.sqlite3'


def forget_events(path: Path, cell: Cell, before: int) -> None:
    """Remove old events from the journal of a node that is gone, as retention does."""
    store = SqliteStore(path)
    text = StateText(restore(cell, store))
    while not text.go_on():
        pass
    now = Snapshot(text.seq, stamp(cell), text.text)
    store.save(now)
    store.begin_with(now)
    while store.remove_batch(before):
        pass
    store.close()


def restored_copy(path: Path, copy: Path) -> None:
    """Bring a copy of a journal back in another place; its node is gone."""
    bring_back(path, copy)
