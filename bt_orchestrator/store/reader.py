"""Reading a journal while its orchestrator writes it, or when there is none (formats: events)."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bt_orchestrator.model.history import JobRecord, job_from_plain
from bt_orchestrator.store.database import (
    JournalUnusable,
    has_log,
    unchanging,
    unusable_otherwise,
)
from bt_orchestrator.store.schema import schema_of

PAGE = 1000
"""Records that one query fetches: nobody keeps the writer from tidying up for long."""


@dataclass(frozen=True)
class Wanted:
    """Which records somebody wants."""

    after_seq: int = 0
    job: str | None = None
    events: tuple[str, ...] = ()
    """Names; one that ends with a dot or a star stands for all that begin so; empty: all."""
    since: float | None = None
    """Seconds since the epoch, this moment included."""
    until: float | None = None

    def condition(self) -> tuple[str, list[Any]]:
        """Return what SQLite is to look for."""
        parts: list[str] = ['seq > ?']
        found: list[Any] = [self.after_seq]
        conditions = (
            ("json_extract(record, '$.job') = ?", self.job),
            ("json_extract(record, '$.time') >= ?", self.since),
            ("json_extract(record, '$.time') <= ?", self.until),
        )
        for part, value in conditions:
            if value is not None:
                parts.append(part)
                found.append(value)
        if self.events:
            parts.append(f'({" OR ".join([_EVENT_GLOB] * len(self.events))})')
            found += [_as_glob(name) for name in self.events]
        return ' AND '.join(parts), found


_EVENT_GLOB = "json_extract(record, '$.event') GLOB ?"


def _as_glob(name: str) -> str:
    return f'{name}*' if name.endswith('.') else name


class JournalReader:
    """A journal that is only read: no lock, no node, nothing in it changes. A context."""

    def __init__(self, path: Path) -> None:
        """Open a journal.

        :raises JournalUnusable: it is not there, not ours, newer, or damaged
        """
        self._path = path
        if not path.is_file():
            raise JournalUnusable(f'there is no journal {path}')
        with unusable_otherwise(path):
            if not has_log(path):
                with closing(unchanging(path)) as database:
                    schema_of(database, path)
            self._database = _opened(path)
            try:
                self._schema = schema_of(self._database, path)
            except BaseException:
                self._database.close()
                raise

    def __enter__(self) -> JournalReader:
        return self

    def __exit__(self, *exception: object) -> None:
        self._database.close()

    def first_seq(self) -> int:
        """Return the number of the oldest event that is kept; 0: there is none."""
        with unusable_otherwise(self._path):
            found = self._database.execute('SELECT min(seq) FROM events').fetchone()[0]
        return int(found or 0)

    def records(self, wanted: Wanted) -> Iterator[tuple[int, str]]:
        """Yield the records that somebody wants, oldest first: number, and JSON text.

        :raises JournalUnusable: the file is damaged
        """
        condition, values = wanted.condition()
        query = f'SELECT seq, record FROM events WHERE {condition} ORDER BY seq LIMIT {PAGE}'
        while True:
            with unusable_otherwise(self._path):
                page = self._database.execute(query, values).fetchall()
            yield from page
            if len(page) < PAGE:
                return
            values[0] = page[-1][0]

    def last_seq(self) -> int:
        """Return the number of the newest event; 0: there is none."""
        with unusable_otherwise(self._path):
            found = self._database.execute('SELECT max(seq) FROM events').fetchone()[0]
        return int(found or 0)

    def summaries(self) -> Sequence[JobRecord]:
        """Return what is kept of jobs that ended, their events or not, oldest first."""
        if self._schema < 2:
            return []
        with unusable_otherwise(self._path):
            rows = self._database.execute('SELECT summary FROM jobs ORDER BY queued').fetchall()
            return [job_from_plain(json.loads(summary)) for (summary,) in rows]


def _opened(path: Path) -> sqlite3.Connection:
    """Open a file for reading.

    SQLite wants to make files beside a journal even to read it. Where it may not, and no writer
    has left any, the file cannot change, and is opened as such.
    """
    uri = f'{path.resolve().as_uri()}?mode=ro'
    database = sqlite3.connect(uri, uri=True, timeout=10.0)
    try:
        database.execute('SELECT 1 FROM sqlite_schema').fetchone()
    except sqlite3.OperationalError:
        database.close()
        if path.with_name(path.name + '-wal').exists():
            raise
        return sqlite3.connect(f'{uri}&immutable=1', uri=True)
    return database
