"""The rows of events: checked when they are read, removed from the front by jobs, and scanned."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import closing
from typing import Any, NamedTuple

from bt_orchestrator.base.errors import DamagedRecord
from bt_orchestrator.model.codec import from_record, json_of
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.jobs.job_record import JobRecord, job_from_plain, job_to_plain
from bt_orchestrator.model.keeping.records import Damage, JobPlace, Record, Summaries, Wanted
from bt_orchestrator.model.limits import fitting
from bt_orchestrator.store.shared import books
from bt_orchestrator.store.shared.database import (
    Check,
    Database,
    check_of,
    check_of_event,
    keep_from,
    replace,
)

_PAGE, _PAGE_BYTES = 1000, 1_000_000
"""Limits of one query: events, and bytes of their records."""

BATCH = 2000
"""Most events that one transaction removes."""


COLUMNS = 'seq, CAST(record AS BLOB), checksum, ends'
"""Those of a `Row`."""


class Row(NamedTuple):
    """The row of an event in the file."""

    seq: int
    text: bytes
    checksum: int | None
    ends: int | None

    def is_sound(self, checked_from: int, check: Check = check_of_event) -> bool:
        """Tell whether the row is undamaged, as far as that can be checked.

        :param checked_from: events before this one were written without a check
        """
        if self.checksum is None:
            return self.seq < checked_from and _is_json(self.text)
        return self.checksum == check(self.seq, self.text, self.ends or 0)


def _is_json(text: bytes) -> bool:
    try:
        json.loads(text)
    except ValueError:
        return False
    return True


def page(database: Database, after: int, last: int, most: int) -> list[Row]:
    """Return the next rows, if any; no query stays open, as that would keep the file open.

    :param most: maximum number; -1: as many as one query reads
    """
    query = f'SELECT {COLUMNS} FROM events WHERE seq > ? AND seq <= ? ORDER BY seq LIMIT ?'
    wanted = _PAGE if most < 0 else min(most, _PAGE)
    with closing(database.execute(query, (after, last, wanted))) as rows:
        return list(fitting(map(Row._make, rows), _PAGE_BYTES, lambda row: len(row.text)))


def events_of(
    rows: Iterable[Row], before: int, checked_from: int, check: Check = check_of_event
) -> Iterator[Event]:
    """Yield the events of consecutive rows; a damaged commit yields no event.

    :param before: the event that came before these
    :raises DamagedRecord: this one is damaged or missing
    """
    commit: list[Event] = []
    for row in rows:
        if row.seq != before + 1:
            raise DamagedRecord(before + 1, row.seq - 1, 'not there')
        if not row.is_sound(checked_from, check):
            raise DamagedRecord(row.seq, row.seq, 'damaged')
        commit.append(from_record(json.loads(row.text)))
        before = row.seq
        if row.ends != 0:
            yield from commit
            commit.clear()
    yield from commit


def last_seq(database: Database) -> int:
    """Return the seq of the last event; 0: there is none."""
    (last,) = database.execute('SELECT coalesce(max(seq), 0) FROM events').fetchone()
    return int(last)


def remove_after(database: Database, seq: int) -> None:
    """Remove the rows after an event."""
    for table in ('events', 'queued', 'snapshots'):
        database.execute(f'DELETE FROM {table} WHERE seq > ?', (seq,))
    books.forget(database, seq)


def first_needed(database: Database, live: Collection[str], keep_jobs: int) -> int:
    """Return the seq of the first event that must stay; 0: none has to go.

    That is the beginning of the first job that is live or among the last `keep_jobs` others. So
    every such job is kept from its beginning.
    """
    queued = database.execute('SELECT seq, job FROM queued ORDER BY seq').fetchall()
    others = [seq for seq, job in queued if job not in live]
    if len(others) <= keep_jobs:
        return 0
    last = database.execute('SELECT max(seq) FROM events').fetchone()[0]
    needed = [seq for seq, job in queued if job in live] + others[len(others) - keep_jobs :]
    return int(min(needed, default=last + 1))


def remove_batch(database: Database, before: int) -> bool:
    """Remove the first events before a seq; return whether there are more.

    Never removes what replay needs: the events after the state that it begins with.
    """
    first = database.execute('SELECT min(seq) FROM events').fetchone()[0]
    if first is None:
        return False
    kept = database.execute('SELECT coalesce(max(seq), 0) FROM beginning').fetchone()[0]
    end = min(before, kept + 1)
    now = min(end, first + BATCH)
    for table in ('events', 'queued'):
        database.execute(f'DELETE FROM {table} WHERE seq < ?', (now,))
    # The state at the event before stays: the remaining past states need it.
    database.execute('DELETE FROM snapshots WHERE seq < ?', (now - 1,))
    books.forget_states(database, now)
    keep_from(database, now)
    return bool(first + BATCH < end)


# Summaries of jobs that ended, kept after their events are removed.


def keep_summaries(database: Database, ended: Sequence[JobRecord]) -> None:
    """Write the summaries of jobs, replacing earlier ones."""
    texts = [(job.job, job.queued, json_of(job_to_plain(job))) for job in ended]
    rows = [(*row, check_of(0, row[-1].encode())) for row in texts]
    replace(database, 'jobs', 'job, queued', 'summary, checksum', rows)


def summary_page(
    database: Database,
    after: JobPlace | None,
    most: int,
    *,
    newest_first: bool,
) -> Summaries:
    """Return the next jobs, as they were queued."""
    compare, order = ('<', 'DESC') if newest_first else ('>', 'ASC')
    name = 'CAST(job AS BLOB)'  # a damaged one may not be valid text
    where = '' if after is None else f'WHERE (queued, {name}) {compare} (?, ?)'
    values = () if after is None else (after.queued, after.job.encode(errors=_AS_IT_IS))
    query = (
        f'SELECT queued, {name}, CAST(summary AS BLOB), checksum FROM jobs {where} '
        f'ORDER BY queued {order}, {name} {order} LIMIT ?'
    )
    rows = database.execute(query, (*values, most + 1)).fetchall()
    jobs: list[JobRecord] = []
    damage: list[Damage] = []
    for _, job, text, checksum in rows[:most]:
        if checksum is None or checksum == check_of(0, text):
            jobs.append(job_from_plain(json.loads(text)))
        else:
            damage.append(
                Damage(f'the summary of job {job.decode(errors="replace")!r} is damaged')
            )
    rest = None
    if rows[most:]:
        queued, job = rows[most - 1][:2]
        rest = JobPlace(queued, job.decode(errors=_AS_IT_IS))
    return Summaries(jobs, damage, rest)


_AS_IT_IS = 'surrogateescape'


# One scan of the rows of events for the wanted records.

MOST = 1000
"""Most records of a page."""

MOST_BYTES = 1_000_000
"""A page ends with the record that makes it this long."""

LOOKED_AT = 20_000
"""A page ends after so many rows, wanted or not: the log grows during a long scan."""


_AT_ONCE = 200
"""Rows of one query."""


class Terms(NamedTuple):
    """The terms of SQL for what may be wanted of a record; `?` is the value."""

    job: str
    since: str
    until: str
    event: str
    """By a name with `*` as wildcard."""
    if_sound: str = '{}'
    """Around a condition that fails on a damaged record."""
    check: Check = check_of_event
    """Of the rows."""

    def condition(self, wanted: Wanted) -> tuple[str, list[Any]]:
        """Return the SQL condition for wanted records, and its values."""
        terms = ((self.job, wanted.job), (self.since, wanted.since), (self.until, wanted.until))
        given = [(term, value) for term, value in terms if value is not None]
        parts = [term for term, _ in given]
        if wanted.events:
            parts.append(f'({" OR ".join([self.event] * len(wanted.events))})')
        values = [value for _, value in given]
        condition = self.if_sound.format(' AND '.join(parts) or 'TRUE')
        return condition, [*values, *wanted.patterns]


class Look:
    """Finds the records of a page, and the damaged or missing ones between them."""

    def __init__(self, wanted: Wanted, low: int, high: int, most: int) -> None:
        """Begin.

        :param low: seq of the first event that must exist
        :param high: seq of the last one
        """
        self._wanted = wanted
        self._low, self._high = low, high
        self._most = max(1, min(most, MOST))
        self._next, self._step = (high, -1) if wanted.newest_first else (low, 1)
        """The expected number of the next row, and the step to the one after it."""
        self.found: list[Record] = []
        self.damaged: list[DamagedRecord] = []
        self.rest = wanted
        self.is_last = False

    def through(self, database: Database, terms: Terms, checked_from: int) -> None:
        """Scan the rows.

        :param checked_from: events before this one were written without a check
        """
        length = 0
        for looked, (seq, text) in enumerate(self._rows(database, terms, checked_from), 1):
            if seq != self._next:
                self._come_to(seq)
            self._next = seq + self._step
            if text is None:
                self.damaged.append(DamagedRecord(seq, seq, 'damaged'))
            elif text:
                length += len(text)
                self._take(seq, text)
            if len(self.found) == self._most or length > MOST_BYTES or looked == LOOKED_AT:
                self.rest = self._wanted.past(seq)
                return
        self._come_to_the_end()

    def _rows(
        self, database: Database, terms: Terms, checked_from: int
    ) -> Iterator[tuple[int, bytes | None]]:
        """Yield numbers with their record; None: it is damaged; empty: it is not wanted."""
        condition, values = terms.condition(self._wanted)
        order = 'DESC' if self._wanted.newest_first else 'ASC'
        query = (
            f'SELECT {condition}, {COLUMNS} FROM events '
            f'WHERE seq BETWEEN ? AND ? ORDER BY seq {order} LIMIT {_AT_ONCE}'
        )
        low, high = self._low, self._high
        while chunk := database.execute(query, (*values, low, high)).fetchall():
            for is_wanted, *columns in chunk:
                row = Row(*columns)
                text = row.text if is_wanted else b''
                yield row.seq, text if row.is_sound(checked_from, terms.check) else None
            low, high = (low, row.seq - 1) if self._wanted.newest_first else (row.seq + 1, high)

    def _take(self, seq: int, text: bytes) -> None:
        try:
            self.found.append(Record(seq, text.decode()))
        except UnicodeDecodeError:  # a row without a check
            self.damaged.append(DamagedRecord(seq, seq, 'damaged'))

    def _come_to(self, seq: int) -> None:
        """Note the rows missing before this one."""
        if self._wanted.newest_first:
            self._miss(seq + 1, self._next)
        else:
            self._miss(self._next, seq - 1)

    def _come_to_the_end(self) -> None:
        """Note the rows missing after the last one."""
        end = self._low - 1 if self._wanted.newest_first else self._high + 1
        self._come_to(end)
        self.rest = self._wanted.past(end + 1 if self._wanted.newest_first else end - 1)
        self.is_last = True

    def _miss(self, first: int, last: int) -> None:
        if first <= last:
            self.damaged.append(DamagedRecord(first, last, 'not there'))
