"""What other programs do to a journal while it is written: nothing that was committed is lost.

A process has one POSIX lock on a file, and loses it when it closes any descriptor of that file.
Then the next program that opens the journal and closes it takes its log away.
"""

from __future__ import annotations

import os
import shutil
import sqlite3
from collections.abc import Iterator
from pathlib import Path

import pytest
from fakes.other_python import back_up, run_python

from bt_orchestrator.base.errors import JournalFailed
from bt_orchestrator.model.events import Event, JobStarted
from bt_orchestrator.ports import Snapshot
from bt_orchestrator.store.sqlite import keeping, opening
from bt_orchestrator.store.sqlite.database import unchanging
from bt_orchestrator.store.sqlite.store import SqliteStore

LAST = """
import sqlite3, sys
print(sqlite3.connect(sys.argv[1]).execute('SELECT max(seq) FROM events').fetchone()[0])
"""

ADD = """
import sqlite3, sys
database = sqlite3.connect(sys.argv[1])
database.execute('INSERT INTO events SELECT max(seq) + 1, record, checksum, ends FROM events')
database.commit()
"""


EMPTY = """
import sqlite3, sys
sqlite3.connect(sys.argv[1]).execute('PRAGMA wal_checkpoint(TRUNCATE)')
"""


def events(first: int, last: int) -> list[Event]:
    return [JobStarted(seq=n, time=n / 2, job=f'WO-{n}') for n in range(first, last + 1)]


def last_for_others(path: Path) -> int:
    """Return the last event that another process finds."""
    return int(run_python('-c', LAST, str(path)))


def log_of(path: Path) -> Path:
    return path.with_name(path.name + '-wal')


@pytest.fixture
def killed(tmp_path: Path) -> Path:
    """Give a journal of 100 events whose writer was killed: they are in its log."""
    written = tmp_path / 'written.sqlite3'
    store = SqliteStore(written)
    for first in range(1, 100, 10):
        store.append(events(first, first + 9))
    path = tmp_path / 'left' / 'journal.sqlite3'
    path.parent.mkdir()
    shutil.copy(written, path)
    shutil.copy(log_of(written), log_of(path))
    store.close()
    return path


@pytest.fixture(params=['new', 'settled'])
def store(
    killed: Path, request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch
) -> Iterator[SqliteStore]:
    """Give the store of the next process, which has written one event.

    Settled: the stamp of its folder proves that its files are in place.
    """
    is_settled = request.param == 'settled'
    for name in ('SETTLED_S', 'SETTLED_COARSE_S'):
        monkeypatch.setattr(keeping, name, 0.0 if is_settled else 3600.0)
    opened = SqliteStore(killed)
    assert list(opened.read(after=99)) == events(100, 100)
    opened.append(events(101, 101))
    assert opened._files is not None
    for _ in range(2 * is_settled):
        opened._files.check()
    assert (opened._files._proven == opened._files._found) is is_settled
    yield opened
    opened.close()


def locks_on(path: Path) -> list[str]:
    """Return the POSIX locks that this process has on a file."""
    place = path.stat()
    file = f'{os.major(place.st_dev):02x}:{os.minor(place.st_dev):02x}:{place.st_ino}'
    locks = [line.split() for line in Path('/proc/locks').read_text().splitlines()]
    mine = [words for words in locks if words[1] == 'POSIX' and words[4] == str(os.getpid())]
    return [words[3] for words in mine if words[5] == file]


def test_writer_keeps_its_lock_after_takeover(store: SqliteStore, killed: Path) -> None:
    store.append(events(102, 102))
    assert locks_on(killed) == ['READ']


@pytest.mark.parametrize('half_read', ['read', 'snapshots'])
def test_what_was_read_in_part_keeps_no_descriptor(killed: Path, half_read: str) -> None:
    first = SqliteStore(killed)
    first.append(events(101, 1500))
    first.save(Snapshot(1500, 'stamp', '{}'))
    first.save(Snapshot(1501, 'stamp', '{}'))
    first.close()
    store = SqliteStore(killed)
    reading = getattr(store, half_read)()
    next(reading)
    store.append(events(1501, 1501))
    rest = [event.seq for event in reading]
    assert rest == (list(range(2, 1502)) if half_read == 'read' else [1500])
    del reading
    assert locks_on(killed) == ['READ']
    store.close()


def test_backup_after_takeover_removes_nothing(store: SqliteStore, killed: Path) -> None:
    copy = back_up(killed)
    assert last_for_others(copy) == 101
    store.append(events(102, 300))
    assert last_for_others(killed) == 300
    assert last_for_others(back_up(killed)) == 300
    store.append(events(301, 301))
    assert log_of(killed).stat().st_size > 0
    assert last_for_others(killed) == 301


def test_a_backup_between_reading_and_the_first_write(killed: Path) -> None:
    store = SqliteStore(killed)
    assert len(list(store.read())) == 100
    back_up(killed)  # the only one that has the file open for writing: it empties the log
    assert not log_of(killed).exists()
    assert list(store.read()) == events(1, 100)
    store.append(events(101, 101))
    assert last_for_others(killed) == 101
    assert list(store.read(after=1)) == events(2, 101)
    store.close()


def test_a_backup_between_the_two_connections(
    killed: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened = opening.to_write

    def interrupted(path: Path, synchronous: str) -> object:
        back_up(path)
        return opened(path, synchronous)

    store = SqliteStore(killed)
    monkeypatch.setattr(opening, 'to_write', interrupted)
    store.append(events(101, 101))
    assert list(store.read()) == events(1, 101)
    assert last_for_others(killed) == 101
    store.close()


def test_journal_changed_by_another_program_is_refused(killed: Path) -> None:
    store = SqliteStore(killed)
    assert len(list(store.read())) == 100
    run_python('-c', ADD, str(killed))
    with pytest.raises(JournalFailed, match=r'ended with event 100 .* ends with event 101 now'):
        store.append(events(101, 101))
    assert len(list(store.read(most=100))) == 100  # it can still be looked at
    store.close()


@pytest.mark.parametrize('ending', ['', '-wal', '-shm'])
@pytest.mark.parametrize('how', ['removed', 'replaced'])
def test_removed_or_replaced_file_is_noticed_at_once(
    store: SqliteStore, killed: Path, ending: str, how: str
) -> None:
    file = killed.with_name(killed.name + ending)
    other = file.rename(file.with_name('away'))
    if how == 'replaced':
        shutil.copy(other, file)
    with pytest.raises(JournalFailed, match=f'{file.name} was {how}'):
        store.append(events(102, 102))


def test_file_from_older_folder_copy_is_noticed(store: SqliteStore, killed: Path) -> None:
    times = killed.parent.stat()
    other = killed.with_name('copy')
    shutil.copy(log_of(killed), other)
    other.rename(log_of(killed))
    os.utime(killed.parent, ns=(times.st_atime_ns, times.st_mtime_ns))  # as `rsync -a` does
    with pytest.raises(JournalFailed, match='-wal was replaced'):
        store.append(events(102, 102))


@pytest.mark.parametrize('how', ['No such file', 'was replaced'])
def test_a_folder_that_is_moved_is_noticed(store: SqliteStore, killed: Path, how: str) -> None:
    other = killed.parent.rename(killed.parent.with_name('elsewhere'))
    if how == 'was replaced':
        shutil.copytree(other, killed.parent)
    with pytest.raises(JournalFailed, match=how):
        store.append(events(102, 102))


@pytest.mark.parametrize('ending', ['', '-wal'])
def test_truncated_file_is_noticed_before_any_write(
    store: SqliteStore, killed: Path, ending: str
) -> None:
    file = killed.with_name(killed.name + ending)
    size = 2000 if ending else file.stat().st_size // 2  # within the first frame of a log
    os.truncate(file, size)
    with pytest.raises(JournalFailed, match=f'{file.name} was cut'):
        store.append(events(102, 102))
    assert file.stat().st_size == size


def test_log_emptied_by_sqlite_is_accepted(store: SqliteStore, killed: Path) -> None:
    run_python('-c', EMPTY, str(killed))
    assert log_of(killed).stat().st_size == 0
    store.append(events(102, 102))
    assert last_for_others(killed) == 102


def test_writing_process_never_opens_the_file_twice(store: SqliteStore, killed: Path) -> None:
    with pytest.raises(AssertionError, match='would lose its locks'):
        unchanging(killed)


def test_journal_without_log_gets_one_when_written(killed: Path) -> None:
    database = sqlite3.connect(killed)
    database.execute('PRAGMA journal_mode = DELETE')
    database.close()
    store = SqliteStore(killed)
    store.append(events(101, 101))
    store.append(events(102, 102))
    assert last_for_others(killed) == 102
    log_of(killed).unlink()
    with pytest.raises(JournalFailed, match='-wal was removed'):
        store.append(events(103, 103))
    store.close()
