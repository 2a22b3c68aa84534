"""Opening a journal: lock it, open it for reading, and for writing only at the first write."""

from __future__ import annotations

import errno
import fcntl
import os
import sqlite3
from pathlib import Path
from typing import IO

from bt_orchestrator.base.errors import JournalUnusable
from bt_orchestrator.store.shared.mark import Reached, mark_of
from bt_orchestrator.store.sqlite.database import (
    RESTORE,
    cannot_open,
    has_log,
    log_of,
    unchanging,
)
from bt_orchestrator.store.sqlite.keeping import make_folder, make_private
from bt_orchestrator.store.sqlite.schema import (
    SCHEMA,
    bring_up_to_date,
    is_closed,
    schema_of,
)


def take_lock(path: Path) -> IO[str]:
    """Take the lock beside a journal."""
    try:
        _refuse_circle(path)
        make_folder(path.parent)
        make_private(_lock_of(path))
        lock = _lock_of(path).open('a+')
    except OSError as error:
        raise JournalUnusable(cannot_open(path, error.strerror)) from error
    try:
        _claim(lock, path, fcntl.LOCK_EX)
    except BaseException:
        lock.close()
        raise
    _sign(lock)
    return lock


def _refuse_circle(path: Path) -> None:
    try:
        path.resolve()
    except RuntimeError:  # a link that leads to itself; Python 3.13 leaves it to who opens it
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), str(path)) from None


def refuse_in_use(copy: Path) -> None:
    """Check that no orchestrator writes a file that is only read here.

    :raises JournalUnusable: one does
    """
    try:
        with _lock_of(copy).open() as lock:
            _claim(lock, copy, fcntl.LOCK_SH)
    except FileNotFoundError:
        pass
    except PermissionError as error:
        raise JournalUnusable(
            f'it cannot be seen whether a node has {copy} in use ({_lock_of(copy).name}: '
            f'{error.strerror}); do this as the user of that node, or of a copy in another folder'
        ) from error


def _claim(lock: IO[str], path: Path, how: int) -> None:
    """Lock an open file beside a journal, or say which process has locked it."""
    try:
        fcntl.flock(lock, how | fcntl.LOCK_NB)
    except OSError:
        lock.seek(0)
        owner = lock.read().strip() or 'unknown'
        raise JournalUnusable(
            f'the journal {path} is in use by another orchestrator (process {owner}); stop that '
            'one, or name another file'
        ) from None


def _lock_of(path: Path) -> Path:
    return path.with_name(path.name + '.lock')


def _sign(lock: IO[str]) -> None:
    """Write the lock's owner into the file, for people; the lock does not depend on it."""
    try:
        lock.truncate(0)
        lock.write(f'{os.getpid()}\n')
        lock.flush()
    except OSError:
        pass


def to_read(path: Path, reached: Reached | None) -> sqlite3.Connection | None:
    """Open a journal of the current schema for reading; None: it must be created or upgraded.

    :param reached: content of its mark
    :raises JournalUnusable: it is not ours, newer, or may not be written; an older one: damaged
    """
    if not path.exists() or not path.stat().st_size:
        if has_log(path):
            raise JournalUnusable(
                f'the journal {path} is missing, and its newest events are in '
                f'{log_of(path).name}: put both back, or move the log away'
            )
        if reached is not None and reached.seq:
            raise JournalUnusable(
                f'the journal {path} is missing: {mark_of(path).name} says that it was written up '
                f'to event {reached.seq}. Put it back, or restore a backup; on a line that was '
                f'cleared by hand, move {mark_of(path).name} away to begin with a new one'
            )
        return None
    if not (os.access(path, os.R_OK | os.W_OK) and os.access(path.parent, os.W_OK)):
        raise JournalUnusable(cannot_open(path, os.strerror(errno.EACCES)))
    database = unchanging(path)
    try:
        version = schema_of(database, path)
        if version == SCHEMA:
            _look_where_a_run_writes(database)
            return database
        # An older journal is upgraded next, which takes longer than a check of all of it.
        (result,) = database.execute('PRAGMA quick_check(1)').fetchone()
        if result != 'ok':
            raise JournalUnusable(f'the journal {path} cannot be used: {result}; {RESTORE}')
    except BaseException:
        database.close()
        raise
    database.close()
    return None


def _look_where_a_run_writes(database: sqlite3.Connection) -> None:
    """Check that SQLite can read the pages where the first events and orders are written.

    The other data of a run, states and summaries, is not essential.
    """
    for table in ('events', 'queued', 'history', 'unclosed'):
        database.execute(f'SELECT max(rowid) FROM {table}').fetchone()


def to_write(path: Path, synchronous: str) -> sqlite3.Connection:
    """Open a journal for writing, and upgrade it to the current schema."""
    if not path.exists():
        make_private(path)
    database = sqlite3.connect(path, isolation_level=None, timeout=10.0, check_same_thread=False)
    try:
        version = schema_of(database, path)
        database.execute('PRAGMA journal_mode = WAL')
        database.execute(f'PRAGMA synchronous = {synchronous}')
        if version < SCHEMA:
            bring_up_to_date(database, version)
    except BaseException:
        database.close()
        raise
    return database


def beside_writer(path: Path) -> sqlite3.Connection:
    """Open a journal that this process writes a second time, to read it meanwhile."""
    database = sqlite3.connect(path, isolation_level=None, timeout=10.0, check_same_thread=False)
    database.execute('PRAGMA query_only = ON')
    return database


def is_cut_off(database: sqlite3.Connection, path: Path) -> bool:
    """Tell whether a node left a log beside a journal, and it is now missing."""
    if has_log(path) or is_closed(database):
        return False
    return not has_log(path)  # a node may have begun writing meanwhile


def cut_off(path: Path, last: int) -> str:
    """Say what is known of a journal without its log and its mark."""
    return (
        f'events after event {last} may be missing: the node that wrote the journal did not close '
        f'it, and neither {log_of(path).name} nor {mark_of(path).name} is there'
    )
