"""The tables of a journal file that a feed copies besides its events: new and changed rows.

Damaged rows are copied as they are, with their checks: a reader of the copy tells of them.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import NamedTuple

from bt_orchestrator.store.sqlite.database import unusable_otherwise
from bt_orchestrator.store.sqlite.records import opened_to_read
from bt_orchestrator.store.sqlite.schema import SCHEMA, schema_of

Key = tuple[int | float | str, ...]


class Table(NamedTuple):
    """A table of a journal whose rows a feed copies."""

    name: str
    keys: tuple[str, ...]
    others: tuple[str, ...]
    check: str = 'checksum'
    """Changes with a row."""
    is_mirrored: bool = False
    """A row that the journal removes is removed from the copy as well."""

    @property
    def columns(self) -> tuple[str, ...]:
        """All of them, the keys first."""
        return self.keys + self.others


TABLES = (
    Table('jobs', ('job', 'queued'), ('summary', 'checksum')),
    Table('snapshots', ('seq',), ('stamp', 'checksum', 'state'), is_mirrored=True),
    Table('beginning', ('one',), ('seq', 'stamp', 'checksum', 'state'), is_mirrored=True),
    Table('book_slots', ('begin_us',), ('until_us', 'made_of', 'version', 'slot', 'checksum')),
    Table(
        'book_states',
        ('seq',),
        ('now_us', 'made_of', 'stays', 'version', 'state', 'checksum'),
        is_mirrored=True,
    ),
    Table('book_scripts', ('digest',), ('script', 'checksum')),
    Table('book_reasons', ('made_of',), ('reason', 'checksum')),
    Table('used_ids', ('digest', 'copy'), ('ids',), check='1'),
)

NOT_COPIED = {
    'events': 'the feed reads them as every reader does, and notices those that are missing',
    'history': 'each history has tables of its own in the copy',
    'queued': 'made anew from the events',
    'unclosed': 'tells of the file',
}
"""The other tables of a journal, and why they are not among these."""


class SideTables:
    """The tables of a journal file of the current schema, at one moment."""

    def __init__(self, database: sqlite3.Connection) -> None:
        self._database = database

    @property
    def history(self) -> str:
        """The history of the journal."""
        return str(self._database.execute('SELECT id FROM history').fetchone()[0])

    def checks(self, table: Table) -> dict[Key, object]:
        """Return the keys of all rows, each with what changes with the row."""
        query = f'SELECT {", ".join(table.keys)}, {table.check} FROM {table.name}'
        return {tuple(row[:-1]): row[-1] for row in self._database.execute(query)}

    def rows(self, table: Table, keys: Collection[Key]) -> Iterator[Sequence[object]]:
        """Yield some rows, as `Table.columns`."""
        where = ' AND '.join(f'{name} = ?' for name in table.keys)
        query = f'SELECT {", ".join(table.columns)} FROM {table.name} WHERE {where}'
        for key in keys:
            yield from self._database.execute(query, key)


@contextmanager
def side_tables(path: Path) -> Iterator[SideTables | None]:
    """Give the tables of a journal; None: an older program wrote it, and they may lack.

    :raises JournalUnusable: it cannot be read
    """
    with unusable_otherwise(path), closing(opened_to_read(path)) as database:
        database.text_factory = _text
        database.execute('BEGIN')
        yield SideTables(database) if schema_of(database, path) == SCHEMA else None


def changed(now: Mapping[Key, object], before: Mapping[Key, object]) -> list[Key]:
    """Return the keys of rows that are new, or not what they were."""
    return [key for key, check in now.items() if key not in before or before[key] != check]


def _text(damaged: bytes) -> str:
    """Return a text that every database takes; a damaged one may have NUL, or be no UTF-8."""
    return damaged.decode(errors='replace').replace('\x00', '�')
