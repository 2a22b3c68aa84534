"""A feed: everything of a journal is in the plant, once, whatever happens to either of them."""

from __future__ import annotations

import json
import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from contract.written_events import events
from fakes.kept_books import book_all
from fakes.long_journal import LongRun

from bt_orchestrator.base.errors import JournalUnusable
from bt_orchestrator.extensions.postgres import sources
from bt_orchestrator.extensions.postgres.connecting import Connection, Place, connected
from bt_orchestrator.extensions.postgres.feed import Copied, Feed
from bt_orchestrator.extensions.postgres.schema import FEED, Gap, enter
from bt_orchestrator.extensions.postgres.sources import DoorSource, FileSource
from bt_orchestrator.model.events import Event, JobStarted, OrchestratorStarted
from bt_orchestrator.model.jobs.job_record import job_from_plain
from bt_orchestrator.model.keeping.records import Wanted
from bt_orchestrator.ports import CellLink
from bt_orchestrator.store.sqlite.copying import NOT_COPIED, TABLES
from bt_orchestrator.store.sqlite.records import SqliteRecords
from bt_orchestrator.store.sqlite.restoring import bring_back
from bt_orchestrator.store.sqlite.schema import SCHEMA
from bt_orchestrator.store.sqlite.store import SqliteStore


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / 'journal.sqlite3'


@pytest.fixture
def feed(connection: Connection) -> Feed:
    return Feed(connection, enter(connection, 'line_1', FEED, 'a test'))


def turn(feed: Feed, path: Path) -> Copied:
    """Copy what is new in a journal file."""
    with closing(FileSource(path)) as source:
        done = feed.copy_events(source)
    feed.copy_tables(path, done)
    feed.is_complete()
    return done


def in_file(path: Path) -> dict[int, str]:
    with closing(SqliteRecords(path)) as records:
        texts: dict[int, str] = {}
        wanted, is_last = Wanted(), False
        while not is_last:
            page = records.page(wanted)
            texts |= {record.seq: record.text for record in page.records}
            wanted, is_last = page.rest, page.is_last
        return texts


def in_plant(connection: Connection) -> list[tuple[str, int, str]]:
    """Return history, number and text of all events."""
    query = b'SELECT history, seq, record FROM plant.events ORDER BY seq, history'
    return [(str(a), int(str(b)), str(c)) for a, b, c in connection.execute(query)]


def count(connection: Connection, view: str) -> int:
    row = connection.execute(f'SELECT count(*) FROM plant.{view}'.encode()).fetchone()
    assert row is not None
    return int(str(row[0]))


def write(path: Path, first: int, last: int, history: str = '') -> None:
    """Append events; with a history, as a node that starts with it."""
    written: list[Event] = events(first, last)
    if history:
        written[0] = OrchestratorStarted(
            seq=first, time=first / 2, cell='line_1', digest='d', history=history
        )
    with closing(SqliteStore(path, synchronous='NORMAL')) as store:
        store.append(written)


def begin(path: Path, last: int) -> str:
    """Write the journal of a node that starts; returns its history."""
    with closing(SqliteStore(path, synchronous='NORMAL')) as store:
        history = store.history
    write(path, 1, last, history)
    return history


def restored(copy: Path, path: Path) -> str:
    return bring_back(copy, path, move_aside=True).history


# --- everything, once -------------------------------------------------------------------------


def test_a_real_run_is_copied_while_it_runs(
    path: Path, feed: Feed, connection: Connection
) -> None:
    """Books are superseded, states come and go, and the copy is that of the end."""
    run = LongRun(path)
    superseded = []
    for number in range(4):
        run.job(f'J{number}', 2)
        book_all(run.store, path)
        turn(feed, path)
        superseded += connection.execute(b'SELECT slot FROM cell_1.book_slots').fetchall()
    run.close()
    done = turn(feed, path)
    assert [(seq, text) for _, seq, text in in_plant(connection)] == sorted(in_file(path).items())
    with closing(sqlite3.connect(path)) as database:
        for table in TABLES:
            columns = ', '.join(table.columns)
            rows = database.execute(f'SELECT {columns} FROM {table.name} ORDER BY 1, 2').fetchall()
            copied = connection.execute(
                f'SELECT {columns} FROM cell_1.{table.name} ORDER BY 1, 2'.encode()
            ).fetchall()
            assert copied == rows, table.name
            if table.name not in ('beginning', 'used_ids', 'book_reasons'):
                assert rows, f'nothing was copied of {table.name}'
            if table.name == 'book_slots':
                assert len({*superseded}) > len(rows), 'no slot was superseded'
    assert done.gaps == []
    assert turn(feed, path) == Copied(), 'a second time there is nothing to do'


def test_the_views_tell_jobs_as_the_journal_does(
    path: Path, feed: Feed, connection: Connection
) -> None:
    run = LongRun(path)
    run.job('J1', 3)
    run.close()
    turn(feed, path)
    columns = 'job, script, quantity, status, packed, rejected, missing, nonconforming, good'
    query = f'SELECT {columns}, produced, summary FROM plant.jobs'.encode()
    (row,) = connection.execute(query).fetchall()
    job = job_from_plain(json.loads(str(row[-1])))
    counts = job.counts
    assert row[:-1] == (
        *(job.job, job.script, job.quantity, job.status, counts.packed, counts.rejected),
        *(counts.missing, counts.nonconforming, counts.good, counts.produced),
    )
    assert counts.packed == 3
    overview = b'SELECT cell, state, stop_reason, last_seq FROM plant.overview'
    assert connection.execute(overview).fetchall() == [
        ('line_1', 'Complete', None, run.orchestrator.state.seq)
    ]


def test_every_journal_table_is_copied_or_excluded(path: Path) -> None:
    SqliteStore(path).close()
    with closing(sqlite3.connect(path)) as database:
        names = database.execute("SELECT name FROM sqlite_schema WHERE type = 'table'").fetchall()
        assert {name for (name,) in names} == {entry.name for entry in TABLES} | NOT_COPIED.keys()
        for table in TABLES:
            columns = database.execute(f'PRAGMA table_info({table.name})').fetchall()
            assert {column[1] for column in columns} == set(table.columns), table.name


def test_killed_feed_resumes_where_it_stopped(
    path: Path, place: Place, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At every write, before and after it was committed."""
    begin(path, 200)
    monkeypatch.setattr(sources, 'MOST', 30)

    class KilledError(Exception):
        pass

    def killed(number: int, *, is_after: bool) -> None:
        calls, write_events = 0, Feed._write_events

        def write_or_die(self: Feed, *given: object) -> None:
            nonlocal calls
            calls += 1
            if calls == number and not is_after:
                raise KilledError
            write_events(self, *given)  # type: ignore[arg-type]
            if calls == number:
                raise KilledError  # within the transaction: nothing of it is there

        with monkeypatch.context() as patch, connected(place, 'test') as connection:
            patch.setattr(Feed, '_write_events', write_or_die)
            feed = Feed(connection, enter(connection, 'line_1', FEED, 'a test'))
            with pytest.raises(KilledError):
                turn(feed, path)

    for number in (1, 2, 3):
        killed(number, is_after=False)
        killed(number, is_after=True)
    with connected(place, 'test') as connection:
        turn(Feed(connection, enter(connection, 'line_1', FEED, 'a test')), path)
        rows = in_plant(connection)
    assert [(seq, text) for _, seq, text in rows] == sorted(in_file(path).items())


# --- histories --------------------------------------------------------------------------------


def test_events_that_two_histories_share_count_once(
    path: Path, feed: Feed, connection: Connection, tmp_path: Path
) -> None:
    """1 to 12; a backup of 8; its node writes 9 to 15."""
    old = begin(path, 8)
    copy = Path(shutil.copy(path, tmp_path / 'backup'))
    write(path, 9, 12)
    turn(feed, path)
    lost = in_file(path)
    new = restored(copy, path)
    assert turn(feed, path).events == 0, 'no node has worked on it yet'
    write(path, 9, 15, new)
    assert turn(feed, path).events == 7
    expected = [(old, seq, text) for seq, text in lost.items()]
    expected += [(new, seq, text) for seq, text in in_file(path).items() if seq > 8]
    assert sorted(in_plant(connection)) == sorted(expected)
    query = (
        b'SELECT history, parent, first_seq, is_current FROM plant.histories ORDER BY first_seq'
    )
    assert connection.execute(query).fetchall() == [(old, None, 1, False), (new, old, 9, True)]


def test_histories_between_two_looks_are_told_apart(
    path: Path, feed: Feed, connection: Connection, tmp_path: Path
) -> None:
    """The second one was never seen by the feed while it was the journal."""
    first = begin(path, 8)
    turn(feed, path)
    write(path, 9, 9)
    second = restored(Path(shutil.copy(path, tmp_path / 'one')), path)
    write(path, 10, 14, second)
    third = restored(Path(shutil.copy(path, tmp_path / 'two')), path)
    write(path, 15, 16, third)
    turn(feed, path)
    rows = in_plant(connection)
    assert [(seq, text) for _, seq, text in rows] == sorted(in_file(path).items())
    owners = [(first, 9), (second, 5), (third, 2)]
    assert [(owner, [row[0] for row in rows].count(owner)) for owner, _ in owners] == owners


def test_history_without_beginning_continues_from_copy(
    path: Path, feed: Feed, connection: Connection, tmp_path: Path
) -> None:
    """Retention removed the start that named the first history."""
    first = begin(path, 8)
    turn(feed, path)
    second = restored(Path(shutil.copy(path, tmp_path / 'one')), path)
    write(path, 9, 12, second)
    remove(path, 5)
    turn(feed, path)
    assert [(seq, owner) for owner, seq, _ in in_plant(connection)] == [
        *((seq, first) for seq in range(1, 9)),
        *((seq, second) for seq in range(9, 13)),
    ]


def test_node_that_lost_events_continues_as_new_history(
    path: Path, feed: Feed, connection: Connection
) -> None:
    begin(path, 12)
    turn(feed, path)
    with closing(SqliteStore(path)) as store:
        store.go_on_after(10)
        store.append([OrchestratorStarted(seq=11, cell='c', digest='d', history=store.history)])
    turn(feed, path)
    assert [seq for _, seq, _ in in_plant(connection)] == [*range(1, 12), 11, 12]


# --- what is missing --------------------------------------------------------------------------


def remove(path: Path, before: int) -> None:
    from bt_orchestrator.ports import Snapshot

    with closing(SqliteStore(path)) as store:
        store.begin_with(Snapshot(before - 1, 'stamp', '{}'))
        while store.remove_batch(before):
            pass


def test_retention_does_not_wait_and_reports_gap(
    path: Path, feed: Feed, connection: Connection
) -> None:
    begin(path, 10)
    turn(feed, path)
    write(path, 11, 40)
    remove(path, 31)
    done = turn(feed, path)
    assert done.gaps == [Gap(11, 30, 'removed')]
    assert str(done.gaps[0]) == (
        'events 11 to 30 were removed from the journal before they could be copied'
    )
    assert [seq for _, seq, _ in in_plant(connection)] == [*range(1, 11), *range(31, 41)]
    assert turn(feed, path).gaps == [], 'told once'
    query = b'SELECT first_seq, last_seq, why FROM plant.gaps'
    assert connection.execute(query).fetchall() == [(11, 30, 'removed')]


def test_damaged_record_is_gap_and_rest_is_copied(
    path: Path, feed: Feed, connection: Connection
) -> None:
    begin(path, 20)
    with closing(sqlite3.connect(path, isolation_level=None)) as database:
        database.execute("UPDATE events SET record = 'x' WHERE seq = 7")
        database.execute('DELETE FROM events WHERE seq IN (9, 10, 20)')
    done = turn(feed, path)
    assert done.gaps == [Gap(7, 7, 'damaged'), Gap(9, 10, 'damaged')]
    write_on(path, 20)
    assert turn(feed, path).gaps == []
    assert count(connection, 'events') == 17


def write_on(path: Path, seq: int) -> None:
    with closing(SqliteStore(path)) as store:
        store.append([JobStarted(seq=seq, job='J')])


def test_feed_refuses_journal_that_lost_its_end(path: Path, feed: Feed) -> None:
    begin(path, 20)
    turn(feed, path)
    with closing(sqlite3.connect(path, isolation_level=None)) as database:
        database.execute('DELETE FROM events WHERE seq > 15')
    with pytest.raises(JournalUnusable, match='ends with event 15, and event 20 of the same'):
        turn(feed, path)


def test_other_files_of_same_history_are_refused(
    path: Path, feed: Feed, connection: Connection, tmp_path: Path
) -> None:
    begin(path, 8)
    shutil.copy(path, tmp_path / 'backup')
    write(path, 9, 12)
    turn(feed, path)
    shutil.copy(tmp_path / 'backup', path)
    write(path, 9, 9)
    with closing(SqliteStore(path)) as store:
        store.append([JobStarted(seq=seq, job='other') for seq in range(10, 15)])
    with pytest.raises(JournalUnusable, match='event 12 of the journal is not the one'):
        turn(feed, path)
    assert count(connection, 'events') == 12


def test_a_journal_of_an_older_program(path: Path, feed: Feed, connection: Connection) -> None:
    """Its events are copied; the tables that it lacks come when a node has upgraded it."""
    begin(path, 8)
    with closing(sqlite3.connect(path, isolation_level=None)) as database:
        database.execute('DROP TABLE book_reasons')
        database.execute(f'PRAGMA user_version = {SCHEMA - 1}')
    assert turn(feed, path).events == 8
    SqliteStore(path).close()
    turn(feed, path)
    assert count(connection, 'events') == 8


# --- over the door ----------------------------------------------------------------------------


class _Door:
    """The part of `ports.CellLink` that a feed uses, of a journal file."""

    def __init__(self, path: Path, most: int) -> None:
        self._path, self._most = path, most

    def events_after(self, seq: int, most: int = 0) -> object:
        from bt_orchestrator.ports import EventPage

        with closing(SqliteStore(self._path)) as store:
            batch = list(store.read(max(seq, store.first_seq() - 1), most or self._most))
            last = max((event.seq for event in store.read()), default=0)
            return EventPage(store.history, batch, store.first_seq(), last)


def test_over_the_door_come_the_same_events(
    path: Path, feed: Feed, connection: Connection, tmp_path: Path
) -> None:
    from typing import cast

    first = begin(path, 8)
    source = DoorSource(cast(CellLink, _Door(path, 3)))
    feed.copy_events(source)
    second = restored(Path(shutil.copy(path, tmp_path / 'one')), path)
    write(path, 9, 12, second)
    feed.copy_events(source)
    rows = in_plant(connection)
    assert [(seq, text) for _, seq, text in rows] == sorted(in_file(path).items())
    assert [owner for owner, _, _ in rows] == [first] * 8 + [second] * 4
    write(path, 13, 40)
    remove(path, 31)
    assert feed.copy_events(source).gaps == [Gap(13, 30, 'removed')]
