"""Reading a journal while its orchestrator writes it, or when there is none (formats: events)."""

from __future__ import annotations

import json
import logging
import sqlite3
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bt_orchestrator.errors import DamagedRecord, JournalUnusable
from bt_orchestrator.model.jobs.job_record import JobRecord, job_from_plain
from bt_orchestrator.store.sqlite.checks import check_of, check_of_event
from bt_orchestrator.store.sqlite.database import has_log, unchanging, unusable_otherwise
from bt_orchestrator.store.sqlite.mark import mark_of, read_mark
from bt_orchestrator.store.sqlite.schema import history_of, kept_from, schema_of

log = logging.getLogger(__name__)

_CHECKED = 4
"""The schema from which on rows have a check."""

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
        parts: list[str] = ['1']
        found: list[Any] = []
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

    @property
    def is_all(self) -> bool:
        """Tell whether every event after a number is wanted."""
        return (self.job, self.events, self.since, self.until) == (None, (), None, None)


_EVENT_GLOB = "json_extract(record, '$.event') GLOB ?"


def _as_glob(name: str) -> str:
    return f'{name}*' if name.endswith('.') else name


class JournalReader:
    """A journal that is only read: no lock, no node, nothing in it changes. A context."""

    def __init__(self, path: Path, tell: Callable[[str], None] = log.warning) -> None:
        """Open a journal.

        :param tell: called with a sentence for every record that is passed over for its damage
        :raises JournalUnusable: it is not there, not ours, newer, or damaged as a whole
        """
        self._path = path
        self._tell = tell
        self.damaged = 0
        """Records that were passed over, or are missing."""
        self._passed_over = 0
        self._told_the_end = False
        if not path.is_file():
            raise JournalUnusable(f'there is no journal {path}')
        with unusable_otherwise(path):
            if not has_log(path):
                with closing(unchanging(path)) as database:
                    schema_of(database, path)
            self._database = _opened(path)
            try:
                self._schema = schema_of(self._database, path)
                self._database.create_function(
                    'check_of_event', 3, check_of_event, deterministic=True
                )
                self._history, self._checked_from = self._read_history()
            except BaseException:
                self._database.close()
                raise

    def __enter__(self) -> JournalReader:
        return self

    def __exit__(self, *exception: object) -> None:
        self._database.close()

    def first_seq(self) -> int:
        """Return the number of the first event that retention has left, or that is to come."""
        with unusable_otherwise(self._path):
            if self._schema >= _CHECKED:
                return kept_from(self._database)
            found = self._database.execute('SELECT min(seq) FROM events').fetchone()[0]
        return int(found or 1)

    def records(self, wanted: Wanted) -> Iterator[tuple[int, str]]:
        """Yield the records that somebody wants, oldest first: number, and JSON text.

        A damaged one is told instead, whatever it was about.

        :raises JournalUnusable: the file is damaged as a whole
        """
        condition, values = wanted.condition()
        query = (
            f'SELECT seq, CAST(record AS BLOB), {self._sound} AS sound FROM events WHERE seq > ? '
            f'AND CASE WHEN {self._sound} THEN {condition} ELSE 1 END ORDER BY seq LIMIT {PAGE}'
        )
        after = wanted.after_seq
        before = max(after, self.first_seq() - 1)
        while True:
            with unusable_otherwise(self._path):
                page = self._database.execute(query, (after, *values)).fetchall()
            for seq, text, is_sound in page:
                if wanted.is_all and seq != before + 1:
                    self._tell_a_gap(before + 1, seq - 1)
                before = seq
                if is_sound:
                    yield seq, text.decode()
                else:
                    self._pass_over(seq, seq, 'damaged')
            if len(page) < PAGE:
                break
            after = page[-1][0]
        self._tell_what_is_gone()

    def _read_history(self) -> tuple[str, int]:
        """Return its name, and the event from which on all have a check."""
        if self._schema < _CHECKED:
            return '', 0
        try:
            found = history_of(self._database)
        except ValueError as error:
            self.damaged += 1
            self._tell(f'{error} in the journal {self._path}: no node will start with it')
            return '', 0
        return found.id, found.checked_from

    def _tell_what_is_gone(self) -> None:
        """Compare the end with the mark, which is written later and never ahead."""
        reached = read_mark(mark_of(self._path))
        if reached is None or reached.history != self._history or self._told_the_end:
            return
        with unusable_otherwise(self._path):
            last = max(self.last_seq(), _beginning_of(self._database))
        if reached.seq > last:
            self._told_the_end = True
            self.damaged += reached.seq - last
            self._tell(
                f'the journal {self._path} ends with event {last}, and event {reached.seq} had '
                'been written: what is between is not in it any more'
            )

    def _tell_a_gap(self, first: int, last: int) -> None:
        """Tell which events are not there, but for those that retention has just removed."""
        first = max(first, self.first_seq())
        if first <= last:
            self._pass_over(first, last, 'not there')

    def _pass_over(self, first: int, last: int, how: str) -> None:
        if last <= self._passed_over:
            return  # it was told when it was met before
        self._passed_over = last
        self.damaged += last + 1 - first
        self._tell(
            f'{DamagedRecord(first, last, how)} in the journal {self._path}, and left out here; a '
            'backup may have what it was'
        )

    def last_seq(self) -> int:
        """Return the number of the newest event; 0: there is none."""
        with unusable_otherwise(self._path):
            found = self._database.execute('SELECT max(seq) FROM events').fetchone()[0]
        return int(found or 0)

    def summaries(self) -> Sequence[JobRecord]:
        """Return what is kept of jobs that ended, their events or not, oldest first."""
        if self._schema < 2:
            return []
        check = 'checksum' if self._schema >= _CHECKED else 'NULL'
        query = (
            f'SELECT CAST(summary AS BLOB), CAST(job AS BLOB), {check} FROM jobs ORDER BY queued'
        )
        with unusable_otherwise(self._path):
            rows = self._database.execute(query).fetchall()
            sound = [text for text, job, check in rows if self._is_sound_summary(text, job, check)]
            return [job_from_plain(json.loads(text)) for text in sound]

    def _is_sound_summary(self, text: bytes, job: bytes, check: int | None) -> bool:
        if check is None or check == check_of(0, text):
            return True
        self.damaged += 1
        name = job.decode(errors='replace')
        self._tell(f'the summary of job {name!r} is damaged in the journal {self._path}')
        return False

    @property
    def _sound(self) -> str:
        """Return the condition, in SQL, under which a record is what was written."""
        if self._schema < _CHECKED:
            return 'json_valid(record)'
        return (
            f'CASE WHEN checksum IS NULL THEN seq < {self._checked_from} AND json_valid(record) '
            'ELSE checksum = check_of_event(seq, CAST(record AS BLOB), coalesce(ends, 0)) END'
        )


def _beginning_of(database: sqlite3.Connection) -> int:
    """Return the event before which replay never begins; 0: it begins with the first."""
    (seq,) = database.execute('SELECT coalesce(max(seq), 0) FROM beginning').fetchone()
    return int(seq)


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
