"""Opening journals; only this module knows how they are stored."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Sequence
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import cast

from bt_orchestrator.base.diagnosis.check import Check
from bt_orchestrator.base.errors import JournalUnusable
from bt_orchestrator.base.extending import POSTGRES
from bt_orchestrator.model.keeping.journal_place import Address, JournalPlace
from bt_orchestrator.model.uptime import ClockReading
from bt_orchestrator.ports import Journal, Records, StandbyJournal


def open_records(journal: JournalPlace) -> Records:
    """Open a journal for reading, whether a node has it or not.

    :raises JournalUnusable: it cannot be read
    :raises ExtensionMissing: it is in a database, and the extension is not installed
    """
    if isinstance(journal, Path):
        from bt_orchestrator.store.sqlite.records import SqliteRecords

        return SqliteRecords(journal)
    return cast('Records', _postgres('records').PostgresRecords(journal))


def open_journal(journal: JournalPlace, synchronous: str) -> Journal:
    """Open a journal for its only writer.

    :param synchronous: FULL or NORMAL, of a file
    :raises JournalUnusable: it cannot be used
    :raises ExtensionMissing: it is in a database, and the extension is not installed
    """
    if isinstance(journal, Path):
        from bt_orchestrator.store.sqlite.store import SqliteStore

        return SqliteStore(journal, synchronous=synchronous)
    if synchronous != 'FULL':
        raise JournalUnusable(
            f'a journal in a database is written with FULL; found {synchronous}: leave '
            '--journal-synchronous out'
        )
    return cast('Journal', _postgres('journal').PostgresStore(journal))


def open_standby(
    journal: JournalPlace, clocks: Callable[[], ClockReading | None]
) -> StandbyJournal:
    """Open a journal that another node writes, to go on with it later.

    :param clocks: reads the clocks of this machine
    :raises JournalUnusable: it is in a file, or cannot be used
    :raises ExtensionMissing: the extension is not installed
    """
    if isinstance(journal, Path):
        raise JournalUnusable(
            'a standby needs a journal that two machines reach: expected --journal '
            f'postgresql://USER@HOST/DATABASE/CELL, found the file {journal}'
        )
    return cast('StandbyJournal', _postgres('standing_by').PostgresStandby(journal, clocks))


def checks_of(journal: Address) -> Iterator[Check]:
    """Yield what `doctor` finds of a journal in a database.

    :raises ExtensionMissing: the extension is not installed
    """
    yield from _postgres('doctoring').checks(journal)


def journals_of(plant: Address) -> Sequence[tuple[str, Address]] | None:
    """Return each cell of a plant's database with the place of its journal; None: it is one.

    :raises JournalUnusable: the database cannot be read
    :raises ExtensionMissing: the extension is not installed
    """
    journals: Sequence[tuple[str, str]] | None = _postgres('overview').journals_of(plant)
    return None if journals is None else [(cell, Address(place)) for cell, place in journals]


def _postgres(module: str) -> ModuleType:
    POSTGRES.demand()
    return import_module(f'{POSTGRES.room}.{module}')


def say_damage(sentence: str) -> None:
    """Report the records of a journal that cannot be shown; the others are shown."""
    print(sentence, file=sys.stderr)
