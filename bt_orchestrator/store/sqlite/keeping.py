"""File operations of a journal: private files, copies under other names, syncing to disk."""

from __future__ import annotations

import os
import shutil
from datetime import datetime, timezone
from pathlib import Path

from bt_orchestrator.base.errors import JournalUnusable
from bt_orchestrator.store.shared.mark import PRIVATE
from bt_orchestrator.store.sqlite.database import log_of


def make_private(path: Path) -> None:
    """Create an empty file with mode PRIVATE, unless it exists."""
    os.close(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_CLOEXEC, PRIVATE))


def make_folder(path: Path) -> None:
    """Create a folder, and missing ones above it, for their owner alone."""
    for folder in (*reversed(path.parents), path):
        folder.mkdir(mode=0o700, exist_ok=True)


def readable_by_others(path: Path) -> str:
    """Say which files of a journal other users may read or write; empty: none."""
    real = path.resolve()
    files = [real, *(real.with_name(real.name + ending) for ending in ('-wal', '-shm'))]
    modes = {file.name: file.stat().st_mode & 0o777 for file in files if file.exists()}
    wide = [f'{name} ({mode:04o})' for name, mode in modes.items() if mode & 0o077]
    return f'others than its owner may open {", ".join(wide)}' if wide else ''


def aside_of(path: Path, why: str) -> Path:
    """Return an unused name beside a journal."""
    return path.with_name(f'{path.name}.{why}-{datetime.now(timezone.utc):%Y%m%dT%H%M%S.%fZ}')


def keep_aside(path: Path, aside: Path) -> None:
    """Copy a closed journal, with its log, to another name.

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
            'written before it is; check the permissions and the free space'
        ) from error


def copy_file(file: Path, copy: Path) -> None:
    """Copy a file to an unused name; it is on disk on return."""
    made = os.open(copy, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, PRIVATE)
    with file.open('rb') as source, os.fdopen(made, 'wb') as target:
        shutil.copyfileobj(source, target, 1 << 20)
        target.flush()
        os.fsync(target.fileno())


def sync(path: Path) -> None:
    """Sync a file, or the names in a folder, to disk."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
