"""A journal that is refused is left as it is, every byte of it and of the files beside it."""

from __future__ import annotations

import shutil
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from fakes.journal_reading import journal_reading
from fakes.line import Line
from fakes.long_journal import LongRun

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.engine.runtime.recovery import restore
from bt_orchestrator.store.shared.database import check_of_event
from bt_orchestrator.store.sqlite.schema import SCHEMA
from bt_orchestrator.store.sqlite.store import SqliteStore

SCHEMA_1 = Path(__file__).parents[3] / 'data' / 'journal_schema_1.sqlite3'
PAGE = 4096


def files(path: Path) -> dict[str, tuple[bytes, int]]:
    """Return what every file of a journal but its lock holds, and when it was written."""
    return {
        file.name: (file.read_bytes(), file.stat().st_mtime_ns)
        for file in path.parent.iterdir()
        if file.suffix != '.lock'
    }


def start(path: Path) -> None:
    """Do with a journal what a tree node does before it writes anything."""
    store = SqliteStore(path)
    try:
        restore(Line().cell, store)
    finally:
        store.close()


def read(path: Path) -> None:
    """Open a journal as the verbs that only read do."""
    with journal_reading(path):
        pass


@contextmanager
def refused_untouched(path: Path, words: str) -> Iterator[None]:
    before = files(path)
    with pytest.raises(OrchestratorError, match=words):
        yield
    assert files(path) == before


def written(path: Path) -> LongRun:
    """Write a journal, which is still open."""
    run = LongRun(path)
    for number in range(5):
        run.job(f'J{number}')
    return run


def ended(folder: Path) -> Path:
    """Return a journal whose orchestrator ended in order."""
    path = folder / 'journal.sqlite3'
    written(path).close()
    return path


def killed(folder: Path) -> Path:
    """Return a journal whose orchestrator was killed: what is new is in the log beside it."""
    run = written(folder / 'killed.sqlite3')
    path = folder / 'left' / 'journal.sqlite3'
    path.parent.mkdir()
    for ending in ('', '-wal', '-shm'):
        shutil.copy(folder / f'killed.sqlite3{ending}', path.with_name(path.name + ending))
    run.kill()
    return path


def killed_without_index(folder: Path) -> Path:
    """Return the same as somebody saved it: the index beside it is not needed."""
    path = killed(folder)
    path.with_name(path.name + '-shm').unlink()
    return path


Made = Callable[[Path], Path]
EVERY_END = pytest.mark.parametrize('made', [ended, killed, killed_without_index])


def change(path: Path, statement: str) -> None:
    """Change a journal, in its log if it has one."""
    scratch = path.parent / 'scratch'
    scratch.mkdir()
    beside = [path.with_name(path.name + ending) for ending in ('', '-wal')]
    copies = [Path(shutil.copy(file, scratch)) for file in beside if file.exists()]
    database = sqlite3.connect(copies[0], isolation_level=None)
    database.execute(statement)
    if len(copies) == 1:
        database.close()  # which empties the log
    for copy in copies:
        shutil.copy(copy, path.parent)
    database.close()
    shutil.rmtree(scratch)


def overwrite(file: Path, first: int, last: int | None = None) -> None:
    """Overwrite these bytes of a file."""
    whole = bytearray(file.read_bytes())
    whole[first:last] = b'\x5a' * len(whole[first:last])
    file.write_bytes(whole)


@pytest.mark.parametrize('table', ['events', 'queued', 'history', 'unclosed'])
def test_tables_written_by_every_run_are_checked_first(tmp_path: Path, table: str) -> None:
    """With a block of the disk that is lost the line would stop at its first event, or order."""
    path = ended(tmp_path)
    database = sqlite3.connect(path)
    query = 'SELECT rootpage FROM sqlite_schema WHERE name = ?'
    (page,) = database.execute(query, (table,)).fetchone()
    (size,) = database.execute('PRAGMA page_size').fetchone()
    database.close()
    overwrite(path, (page - 1) * size, page * size)
    with refused_untouched(path, 'cannot be used: database disk image is malformed'):
        start(path)


@EVERY_END
def test_a_newer_schema(made: Made, tmp_path: Path) -> None:
    path = made(tmp_path)
    change(path, f'PRAGMA user_version = {SCHEMA + 1}')
    with refused_untouched(path, f'has schema {SCHEMA + 1}'):
        start(path)


@EVERY_END
def test_somebody_elses_file(made: Made, tmp_path: Path) -> None:
    path = made(tmp_path)
    change(path, 'PRAGMA application_id = 1')
    with refused_untouched(path, 'no journal of an orchestrator'):
        start(path)


def test_one_that_is_only_read(tmp_path: Path) -> None:
    path = ended(tmp_path)
    change(path, f'PRAGMA user_version = {SCHEMA + 1}')
    with refused_untouched(path, f'has schema {SCHEMA + 1}'):
        read(path)
    overwrite(path, 0, 100)
    with refused_untouched(path, 'file is not a database'):
        read(path)


def test_an_overwritten_header(tmp_path: Path) -> None:
    path = ended(tmp_path)
    overwrite(path, 0, 100)
    with refused_untouched(path, 'file is not a database'):
        start(path)


def test_overwritten_pages(tmp_path: Path) -> None:
    path = ended(tmp_path)
    overwrite(path, 3 * PAGE)
    with refused_untouched(path, 'database disk image is malformed'):
        start(path)


def test_a_record_that_nobody_can_read(tmp_path: Path) -> None:
    path = killed(tmp_path)
    store = SqliteStore(path)
    seq = 1 + max(event.seq for event in store.read())
    store.close()
    text = '{"event": "no.such"}'
    check = check_of_event(seq, text.encode(), 1)
    change(path, f"INSERT INTO events VALUES ({seq}, '{text}', {check}, 1)")
    with refused_untouched(path, 'holds a record that cannot be read'):
        start(path)


def test_overwritten_pages_of_an_older_schema(tmp_path: Path) -> None:
    path = Path(shutil.copy(SCHEMA_1, tmp_path / 'journal.sqlite3'))
    overwrite(path, 5 * PAGE)
    with refused_untouched(path, 'cannot be used'):
        start(path)


@EVERY_END
def test_good_journal_stays_unchanged_until_first_write(made: Made, tmp_path: Path) -> None:
    path = made(tmp_path)
    before = files(path)
    start(path)
    assert files(path) == before
    run = LongRun(path)
    run.job('NEXT')
    run.close()
    assert files(path) != before
