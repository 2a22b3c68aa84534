"""The durable journal, on real SQLite files."""

from __future__ import annotations

import os
import sqlite3
import tracemalloc
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from bt_orchestrator.base.errors import JournalFailed, JournalUnusable
from bt_orchestrator.model.events import Event, JobStarted
from bt_orchestrator.store.shared.database import check_of_event
from bt_orchestrator.store.sqlite.schema import APPLICATION_ID, SCHEMA
from bt_orchestrator.store.sqlite.store import SqliteStore


def events(first: int, last: int) -> list[Event]:
    return [JobStarted(seq=n, time=n / 2, job=f'WO-{n}') for n in range(first, last + 1)]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / 'state' / 'journal.sqlite3'


@pytest.fixture
def store(path: Path) -> Iterator[SqliteStore]:
    opened = SqliteStore(path)
    yield opened
    opened.close()


def refusal(path: Path) -> str:
    with pytest.raises(JournalUnusable) as refused:
        SqliteStore(path)
    return str(refused.value)


def test_long_events_are_read_few_at_a_time(store: SqliteStore) -> None:
    long = [JobStarted(seq=n, time=n / 2, job=f'{n}' * 1_000_000) for n in range(1, 31)]
    for event in long:
        store.append([event])
    tracemalloc.start()
    try:
        first = next(iter(store.read()))
        _, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert first == long[0]
    assert peak < 10_000_000
    assert list(store.read()) == long
    assert list(store.read(after=3, most=2)) == long[3:5]


def test_others_read_while_it_is_open(store: SqliteStore, path: Path) -> None:
    store.append(events(1, 2))
    reader = sqlite3.connect(f'file:{path}?mode=ro', uri=True)
    assert reader.execute('SELECT count(*) FROM events').fetchone() == (2,)
    reader.close()


@pytest.mark.usefixtures('store')
def test_a_second_orchestrator_is_told_who_has_it(path: Path) -> None:
    assert f'in use by another orchestrator (process {os.getpid()})' in refusal(path)


def test_with_normal_no_append_waits_for_the_disk(path: Path) -> None:
    with closing(SqliteStore(path, synchronous='NORMAL')) as store:
        waits: list[bool] = []
        store.at_disk = lambda: waits.append(True)
        store.append(events(1, 3))
    assert not waits


def test_an_append_is_all_or_nothing(store: SqliteStore) -> None:
    store.append(events(1, 2))
    with pytest.raises(JournalFailed, match='event 2 cannot follow event 4'):
        store.append([*events(3, 4), *events(2, 2)])
    assert list(store.read()) == events(1, 2)
    store.append(events(3, 3))
    assert list(store.read()) == events(1, 3)


def test_a_damaged_file_is_refused_and_kept(path: Path) -> None:
    path.parent.mkdir()
    path.write_bytes(b'not a database at all' * 100)
    assert 'cannot be used: file is not a database' in refusal(path)
    assert path.read_bytes() == b'not a database at all' * 100


def test_a_record_that_cannot_be_read_is_refused(path: Path) -> None:
    SqliteStore(path).close()
    database = sqlite3.connect(path)
    text = '{"event": "no.such"}'
    database.execute(
        'INSERT INTO events VALUES (1, ?, ?, 1)', (text, check_of_event(1, text.encode(), 1))
    )
    database.commit()
    database.close()
    store = SqliteStore(path)
    with pytest.raises(JournalUnusable, match=r"cannot be read: KeyError\('no.such'\)"):
        list(store.read())
    store.close()


def test_another_programs_file_is_refused(path: Path) -> None:
    path.parent.mkdir()
    database = sqlite3.connect(path)
    database.execute('CREATE TABLE recipes (name TEXT)')
    database.close()
    assert refusal(path).endswith('no journal of an orchestrator; name another file')


def test_a_newer_schema_is_refused(path: Path) -> None:
    SqliteStore(path).close()
    database = sqlite3.connect(path)
    database.execute(f'PRAGMA user_version = {SCHEMA + 1}')
    database.close()
    assert f'has schema {SCHEMA + 1}, this program knows {SCHEMA}' in refusal(path)


def test_it_is_marked_as_ours(store: SqliteStore, path: Path) -> None:
    reader = sqlite3.connect(path)
    assert reader.execute('PRAGMA application_id').fetchone() == (APPLICATION_ID,)
    assert reader.execute('PRAGMA journal_mode').fetchone() == ('wal',)
    reader.close()


def test_a_link_that_leads_to_itself_is_told(tmp_path: Path) -> None:
    (tmp_path / 'journal').symlink_to('journal')
    pattern = r'cannot be (opened: Too many|used: unable to open)'
    with pytest.raises(JournalUnusable, match=pattern):
        SqliteStore(tmp_path / 'journal')


def test_a_folder_that_cannot_be_made_is_told(tmp_path: Path) -> None:
    (tmp_path / 'file').write_text('')
    assert 'cannot be opened' in refusal(tmp_path / 'file' / 'journal.sqlite3')
