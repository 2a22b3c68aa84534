"""Files beside a journal: made for their owner alone, kept under other names, had on the disk."""

from __future__ import annotations

import os
import shutil
from datetime import datetime, timezone
from pathlib import Path

from bt_orchestrator.errors import JournalUnusable
from bt_orchestrator.store.sqlite.database import log_of

PRIVATE = 0o600
"""What a file of a journal may: its owner reads and writes it. SQLite gives its log the same."""


def make_private(path: Path) -> None:
    """Make an empty file for its owner alone, unless there is one."""
    os.close(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_CLOEXEC, PRIVATE))


def make_folder(path: Path) -> None:
    """Make a folder, and those above it that are not there, for their owner alone."""
    for folder in (*reversed(path.parents), path):
        folder.mkdir(mode=0o700, exist_ok=True)


def readable_by_others(path: Path) -> str:
    """Tell, in words, which files of a journal others may read or write; empty: none."""
    real = path.resolve()
    files = [real, *(real.with_name(real.name + ending) for ending in ('-wal', '-shm'))]
    modes = {file.name: file.stat().st_mode & 0o777 for file in files if file.exists()}
    wide = [f'{name} ({mode:04o})' for name, mode in modes.items() if mode & 0o077]
    return f'others than its owner may open {", ".join(wide)}' if wide else ''


def aside_of(path: Path, why: str) -> Path:
    """Return a name beside a journal that no file has."""
    return path.with_name(f'{path.name}.{why}-{datetime.now(timezone.utc):%Y%m%dT%H%M%S.%fZ}')


def keep_aside(path: Path, aside: Path) -> None:
    """Copy a journal that nobody has open, with its log, to another name.

    :raises JournalUnusable: there is no room for it, or it cannot be read
    """
    real = path.resolve()
    try:
        for file, copy in ((real, aside), (log_of(real), log_of(aside))):
            if file.exists():
                copy_file(file, copy)
    except OSError as error:
        raise JournalUnusable(
            f'the damaged journal cannot be kept as {aside} ({error.strerror}), and nothing is '
            'written before it is'
        ) from error


def copy_file(file: Path, copy: Path) -> None:
    """Copy a file to a name that none has, on the disk when this returns."""
    made = os.open(copy, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, PRIVATE)
    with file.open('rb') as source, os.fdopen(made, 'wb') as target:
        shutil.copyfileobj(source, target, 1 << 20)
        target.flush()
        os.fsync(target.fileno())


def sync(path: Path) -> None:
    """Have a file, or the names in a folder, on the disk."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
