"""A journal that was copied without its log and its mark is not taken for a whole one."""

from __future__ import annotations

import shutil
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from contract.written_events import events
from fakes.journal_reading import journal_reading

from bt_orchestrator.cli.main import main
from bt_orchestrator.model.keeping.records import Wanted
from bt_orchestrator.ports import Snapshot
from bt_orchestrator.store.shared.mark import mark_of
from bt_orchestrator.store.sqlite.database import log_of
from bt_orchestrator.store.sqlite.restoring import bring_back
from bt_orchestrator.store.sqlite.store import SqliteStore


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """Give a journal that was closed with ten events."""
    path = tmp_path / 'written' / 'journal.sqlite3'
    with closing(SqliteStore(path)) as store:
        store.append(events(1, 10))
    return path


@pytest.fixture
def running(path: Path) -> Iterator[SqliteStore]:
    """Give the same, with a node that has written five more."""
    with closing(SqliteStore(path)) as store:
        store.append(events(11, 15))
        yield store


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    return tmp_path / 'copy.sqlite3'


def said_of(path: Path) -> str:
    """Return what a start on a journal says is missing."""
    with closing(SqliteStore(path)) as store:
        return store.missing(max((event.seq for event in store.read()), default=0))


def told_of(path: Path) -> tuple[list[str], int]:
    """Return what a reader of a journal says, and how many records it counts as lost."""
    messages: list[str] = []
    with journal_reading(path, messages.append) as reading:
        list(reading.each(Wanted(job='WO-1')))
    return messages, reading.lost


def copy_all(path: Path, copy: Path) -> None:
    for of in (lambda journal: journal, log_of, mark_of):
        shutil.copy(of(path), of(copy))


WORDS = (
    'events after event {} may be missing: the node that wrote the journal did not close it, and '
    'neither copy.sqlite3-wal nor copy.sqlite3-mark is there'
)


@pytest.mark.usefixtures('running')
def test_lone_file_of_running_node_is_reported(path: Path, copy: Path) -> None:
    shutil.copy(path, copy)
    assert said_of(copy) == WORDS.format(10)
    messages, lost = told_of(copy)
    assert [words.replace(str(copy), 'FILE') for words in messages] == [
        f'the journal FILE may be a part of one: {WORDS.format(10)}'
    ]
    assert lost == 0


@pytest.mark.usefixtures('running')
def test_lone_file_of_killed_node_is_reported(path: Path, copy: Path) -> None:
    left = copy.with_name('left.sqlite3')
    copy_all(path, left)
    shutil.copy(left, copy)
    assert said_of(copy) == WORDS.format(10)
    assert said_of(left) == ''


def test_lone_file_of_new_node_is_reported(tmp_path: Path, copy: Path) -> None:
    """All that it has written is in the log."""
    with closing(SqliteStore(tmp_path / 'new.sqlite3')) as store:
        store.append(events(1, 5))
        shutil.copy(tmp_path / 'new.sqlite3', copy)
    assert said_of(copy) == WORDS.format(0)


def test_a_file_that_was_closed_is_whole(path: Path, copy: Path) -> None:
    shutil.copy(path, copy)
    assert said_of(copy) == ''
    assert told_of(copy) == ([], 0)


@pytest.mark.usefixtures('running')
def test_looking_at_it_closes_and_opens_nothing(path: Path, copy: Path) -> None:
    shutil.copy(path, copy)
    before = copy.read_bytes()
    for _ in range(2):
        assert said_of(copy)
    assert copy.read_bytes() == before


@pytest.mark.usefixtures('running')
def test_the_mark_knows_better(path: Path, copy: Path) -> None:
    """Another program that opens a journal after a crash moves the log into it."""
    copy_all(path, copy)
    with closing(sqlite3.connect(copy)) as database:
        assert database.execute('SELECT max(seq) FROM events').fetchone() == (15,)
    assert not log_of(copy).exists()
    assert said_of(copy) == ''
    assert told_of(copy) == ([], 0)
    mark_of(copy).unlink()
    assert said_of(copy) == WORDS.format(15)


@pytest.mark.usefixtures('running')
def test_a_backup_goes_through_restore(path: Path, copy: Path) -> None:
    """By itself it cannot be told from a part of a journal, and the line went on all the same."""
    with closing(sqlite3.connect(path)) as database, closing(sqlite3.connect(copy)) as target:
        database.backup(target)
    assert said_of(copy) == WORDS.format(15)
    restored = copy.with_name('restored.sqlite3')
    bring_back(copy, restored)
    mark_of(restored).unlink()
    assert said_of(restored) == ''
    assert told_of(restored) == ([], 0)


def test_what_goes_on_after_it_is_whole_again(
    running: SqliteStore, path: Path, copy: Path
) -> None:
    shutil.copy(path, copy)
    with closing(SqliteStore(copy)) as store:
        assert store.missing(10)
        store.go_on_after(10)
        store.append(events(11, 12))
        assert store.history != running.history
    assert said_of(copy) == ''
    mark_of(copy).unlink()
    assert said_of(copy) == ''


def test_node_with_lost_files_does_not_close_journal(path: Path, copy: Path) -> None:
    store = SqliteStore(path)
    store.append(events(11, 15))
    shutil.copy(path, copy)
    log_of(path).rename(log_of(path).with_name('elsewhere'))
    store.close()
    mark_of(path).unlink()
    assert said_of(path).startswith('events after event 15 may be missing')


def test_locked_journal_is_not_marked_as_closed(
    path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    store = SqliteStore(path)
    store.append(events(11, 15))
    with closing(sqlite3.connect(path, isolation_level=None)) as locking:
        locking.execute('BEGIN IMMEDIATE')
        store.close()
    assert 'is left as one that was not closed: database is locked' in caplog.text
    assert said_of(path) == ''
    mark_of(path).unlink()
    assert 'may be missing' in said_of(path)


def test_open_reader_hides_no_loss(path: Path, copy: Path) -> None:
    """The log stays after the node has closed the journal, and holds what the file lacks."""
    store = SqliteStore(path)
    store.append(events(11, 15))
    with closing(sqlite3.connect(path)) as reader:
        reader.execute('BEGIN')
        reader.execute('SELECT max(seq) FROM events').fetchone()
        store.append(events(16, 20))
        store.close()
        shutil.copy(path, copy)
    assert said_of(copy).startswith('events after event 1')
    assert said_of(path) == ''


def test_reader_at_node_start_hides_loss_temporarily(path: Path, copy: Path) -> None:
    """SQLite leaves the file as that reader sees it."""
    store = SqliteStore(path)
    with closing(sqlite3.connect(path)) as reader:
        reader.execute('BEGIN')
        reader.execute('SELECT max(seq) FROM events').fetchone()
        store.append(events(11, 15))
        reader.rollback()
    store.save(Snapshot(15, 'stamp', '{}'))
    shutil.copy(path, copy)
    store.close()
    assert said_of(copy).startswith('events after event 1')


@pytest.mark.usefixtures('running')
def test_verbs_report_loss_and_show_the_rest(
    path: Path, copy: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copy(path, copy)
    for verb in ('history', 'events'):
        assert main([verb, '--journal', str(copy)]) == 0
        assert 'may be a part of one' in capsys.readouterr().err
