"""The contracts of journals, in memory."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from contract.records_contract import RecordsContract, Written
from contract.store_contract import EventStoreContract

from bt_orchestrator.model.events import Event
from bt_orchestrator.ports import EventStore
from bt_orchestrator.store.memory import MemoryRecords, MemoryStore


class TestMemoryStore(EventStoreContract):
    def make(self, folder: Path) -> EventStore:
        return MemoryStore()

    def put_away(self, store: EventStore) -> None:
        """Do nothing: it goes with its process."""


class _Written:
    def __init__(self) -> None:
        self._store = MemoryStore()
        self.records = MemoryRecords(self._store)

    def append(self, events: Sequence[Event]) -> None:
        self._store.append(events)

    def close(self) -> None:
        self.records.close()


class TestMemoryRecords(RecordsContract):
    def make(self, folder: Path) -> Written:
        return _Written()
