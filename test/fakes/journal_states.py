"""The state of a line as its journal tells it."""

from __future__ import annotations

import json
import sqlite3
from pathlib import Path

from fakes.line import Line

from bt_orchestrator.engine.runtime import recovery
from bt_orchestrator.engine.runtime.recovery import restore
from bt_orchestrator.model.keeping.snapshot import state_to_plain
from bt_orchestrator.model.state import CellState
from bt_orchestrator.ports import Snapshot
from bt_orchestrator.store.sqlite.store import SqliteStore

LINE = Line()


def change(path: Path, statement: str) -> None:
    database = sqlite3.connect(path)
    database.execute(statement)
    database.commit()
    database.close()


def restored(path: Path, line: Line = LINE) -> CellState:
    store = SqliteStore(path)
    try:
        return restore(line.cell, store)
    finally:
        store.close()


def kept(state: CellState) -> Snapshot:
    text = json.dumps(state_to_plain(state))
    return Snapshot(state.seq, recovery.stamp(state.cell), text)


def replayed(path: Path) -> CellState:
    """Return what the events alone tell of."""
    change(path, 'DELETE FROM snapshots')
    return restored(path)
