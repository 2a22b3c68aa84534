"""Whether a journal can live in a folder: writing, and locks that other processes respect."""

from __future__ import annotations

import fcntl
import sqlite3
import subprocess
import sys
import tempfile
from pathlib import Path

from bt_orchestrator.base.diagnosis.check import Check, fail, ok

NAME = 'journal folder'

CHILD_S = 30.0
"""Longest time for a Python process that only tries to take a lock."""

_TRY_LOCK = """
import fcntl, sys
try:
    fcntl.flock(open(sys.argv[1], 'a'), fcntl.LOCK_EX | fcntl.LOCK_NB)
except BlockingIOError:
    sys.exit(3)
"""
_REFUSED = 3
ELSEWHERE = 'name a journal on a local disk (ext4, xfs, btrfs)'


def journal_folder(folder: Path) -> Check:
    """Try everything that a journal does with its folder; leaves nothing behind."""
    if not folder.is_dir():
        # As the journal itself would, which makes it.
        return journal_folder(next(parent for parent in folder.parents if parent.is_dir()))
    try:
        with tempfile.TemporaryDirectory(prefix='.bt_orchestrator-', dir=folder) as scratch:
            return _tried(folder, Path(scratch))
    except OSError as error:
        return fail(NAME, f'{folder} cannot be written: {error.strerror}', ELSEWHERE)


def _tried(folder: Path, scratch: Path) -> Check:
    try:
        if not _lock_is_respected(scratch / 'journal.lock'):
            problem = f'{folder}: two processes get the same lock; two nodes could use one journal'
            return fail(NAME, problem, ELSEWHERE)
    except OSError as error:
        return fail(NAME, f'{folder}: no locks there ({error.strerror})', ELSEWHERE)
    mode = _database_mode(scratch / 'journal.db')
    if mode != 'wal':
        problem = f'{folder}: SQLite cannot keep a write-ahead log there ({mode})'
        return fail(NAME, problem, ELSEWHERE)
    return ok(NAME, f'{folder} can be written, locks work')


def _lock_is_respected(path: Path) -> bool:
    with path.open('a') as lock:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        words = [sys.executable, '-c', _TRY_LOCK, str(path)]
        return subprocess.run(words, timeout=CHILD_S, check=False).returncode == _REFUSED


def _database_mode(path: Path) -> str:
    """Return how SQLite writes there: wal, or why it cannot."""
    try:
        database = sqlite3.connect(path)
        try:
            (mode,) = database.execute('PRAGMA journal_mode=WAL').fetchone()
            database.execute('CREATE TABLE tried (number INTEGER)')
            return str(mode)
        finally:
            database.close()
    except sqlite3.Error as error:
        return str(error)
