"""Reading a journal file, with or without a running orchestrator (formats: events)."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

from bt_orchestrator.base.errors import JournalUnusable
from bt_orchestrator.model.keeping.records import Damage
from bt_orchestrator.store.shared.database import Database, History
from bt_orchestrator.store.shared.mark import Reached, mark_of, read_mark
from bt_orchestrator.store.shared.records import UNKNOWN, KeptRecords
from bt_orchestrator.store.shared.rows import Terms
from bt_orchestrator.store.sqlite.database import has_log, unchanging, unusable_otherwise
from bt_orchestrator.store.sqlite.opening import cut_off, is_cut_off
from bt_orchestrator.store.sqlite.schema import CHECKED, look_like_today, schema_of


class SqliteRecords(KeptRecords):
    """A journal file, read-only and without its lock. Implements `ports.Records`."""

    _terms = Terms(
        "json_extract(record, '$.job') = ?",
        "json_extract(record, '$.time') >= ?",
        "json_extract(record, '$.time') <= ?",
        "json_extract(record, '$.event') GLOB ?",
        'CASE WHEN json_valid(record) THEN {} END',
    )

    def __init__(self, path: Path) -> None:
        """Open a journal.

        :raises JournalUnusable: it is not there, not ours, newer, or damaged as a whole
        """
        self._path, self._name = path, str(path)
        if not path.is_file():
            raise JournalUnusable(f'there is no journal {path}; check the path')
        with unusable_otherwise(path):
            if not has_log(path):
                with closing(unchanging(path)) as database:
                    schema_of(database, path)
            self._database = opened_to_read(path)
            try:
                self._schema = schema_of(self._database, path)
                look_like_today(self._database, self._schema)
            except BaseException:
                self._database.close()
                raise

    def close(self) -> None:
        """Close the file."""
        self._database.close()

    def _history(self, database: Database) -> tuple[History, list[Damage]]:
        if self._schema < CHECKED:
            return UNKNOWN, []
        return super()._history(database)

    def _reached(self) -> Reached | None:
        return read_mark(mark_of(self._path))

    def _cut_off(self) -> Iterator[Damage]:
        with unusable_otherwise(self._path):
            if is_cut_off(self._database, self._path):
                with self._one_moment() as database:
                    what = cut_off(self._path, self._ends(database)[1])
                yield Damage(f'the journal {self._path} may be a part of one: {what}', 0)

    @contextmanager
    def _one_moment(self) -> Iterator[sqlite3.Connection]:
        with unusable_otherwise(self._path):
            self._database.execute('BEGIN')
            try:
                yield self._database
            finally:
                self._database.rollback()


def opened_to_read(path: Path) -> sqlite3.Connection:
    """Open a file for reading.

    SQLite creates files beside a journal even to read it. If it may not, and no writer has left
    any, the file is opened as immutable.
    """
    uri = f'{path.resolve().as_uri()}?mode=ro'
    database = sqlite3.connect(uri, uri=True, timeout=10.0, isolation_level=None)
    try:
        database.execute('SELECT 1 FROM sqlite_schema').fetchone()
    except sqlite3.OperationalError:
        database.close()
        if path.with_name(path.name + '-wal').exists():
            raise
        return sqlite3.connect(f'{uri}&immutable=1', uri=True, isolation_level=None)
    return database
