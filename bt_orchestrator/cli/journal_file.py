"""Opening a journal to read it; here alone it is known what keeps it."""

from __future__ import annotations

from pathlib import Path

from bt_orchestrator.ports import Records
from bt_orchestrator.store.sqlite.records import SqliteRecords


def open_records(journal: Path) -> Records:
    """Open a journal for reading, whether a node has it or not.

    :raises JournalUnusable: it cannot be read
    """
    return SqliteRecords(journal)
