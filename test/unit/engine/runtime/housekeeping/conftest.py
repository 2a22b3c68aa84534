"""A journal, and a housekeeper that is quick to look after it."""

from __future__ import annotations

from pathlib import Path

import pytest

from bt_orchestrator.engine.runtime import housekeeping
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.fold import apply
from bt_orchestrator.model.state import CellState


@pytest.fixture(autouse=True)
def soon_at_rest(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let one quiet moment be rest enough, so that a job is looked after when it has ended."""
    monkeypatch.setattr(housekeeping, 'AT_REST', 1)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / 'journal.sqlite3'


@pytest.fixture
def often(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make snapshots after 20 events."""
    monkeypatch.setattr(housekeeping, 'SNAPSHOT_EVERY', 20)


@pytest.fixture
def replays(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Count the events that every start replays."""
    seqs: list[int] = []

    def counting(state: CellState, event: Event) -> None:
        seqs.append(state.seq)
        apply(state, event)

    monkeypatch.setattr('bt_orchestrator.engine.runtime.recovery.apply', counting)
    return seqs
