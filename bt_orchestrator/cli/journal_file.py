"""Opening a journal to read it; only this module knows how it is stored."""

from __future__ import annotations

import sys
from pathlib import Path

from bt_orchestrator.ports import Records
from bt_orchestrator.store.sqlite.records import SqliteRecords


def open_records(journal: Path) -> Records:
    """Open a journal for reading, whether a node has it or not.

    :raises JournalUnusable: it cannot be read
    """
    return SqliteRecords(journal)


def say_damage(sentence: str) -> None:
    """Report the records of a journal that cannot be shown; the others are shown."""
    print(sentence, file=sys.stderr)
