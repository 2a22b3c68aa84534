"""Files of a journal: private, copied, synced to disk, and watched while they are in use."""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Callable, Sequence
from datetime import datetime, timezone
from operator import lt
from pathlib import Path

from bt_orchestrator.base.errors import JournalUnusable
from bt_orchestrator.store.shared.mark import PRIVATE
from bt_orchestrator.store.sqlite.database import is_written, log_of, no_longer_written


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


# Detects that the files of a journal were removed, replaced or cut while in use.

SETTLED_S, SETTLED_COARSE_S = 0.03, 3.0
"""When the next change of a folder is sure to get another time than the last one: where the file
system notes parts of 10 ms, and elsewhere."""


class _Opened:
    """A file that is looked at.

    It is closed after SQLite has closed it: to close one releases the locks of the process on it.
    """

    def __init__(self, path: Path) -> None:
        self.name = str(path)
        self.file = path.open('rb', buffering=0)
        status = os.fstat(self.file.fileno())
        self.identity = status.st_dev, status.st_ino


class FilesInUse:
    """A journal, its log and the log's index; in use until `release`.

    SQLite goes on with files that were removed, replaced or cut, and its commits are lost.

    A name changes only together with the time of change of its folder, which nobody can set. While
    the folder has the time that it had at an earlier look at the names, only sizes are read.
    """

    def __init__(self, path: Path, log_size: Callable[[], int]) -> None:
        """Record the present files.

        :param log_size: returns how many bytes of the log SQLite uses
        """
        self._path = path.resolve()
        log = log_of(self._path)
        self._log = str(log)
        self._log_size = log_size
        self._folder = str(self._path.parent)
        names = self._path, log, log.with_name(f'{self._path.name}-shm')
        self._files = [_Opened(name) for name in names if name.exists()]
        self._descriptors = [journal_file.file.fileno() for journal_file in self._files]
        self._sizes: Sequence[int] = [0] * len(self._files)
        self._found: object = None
        """State of the folder at the last look at the names."""
        self._since = 0.0
        """When it was found first, by the steady clock."""
        self._proven: object = None
        """State of the folder that proves that the names are in place; None: none does yet."""
        is_written(self._path)

    def check_sizes(self) -> None:
        """Check that no file was cut: a write may make it as long as it was.

        :raises JournalUnusable: another program cut a file
        """
        sizes = self._sizes_now()
        if any(map(lt, sizes, self._sizes)):
            self._check_names(sizes)
        self._sizes = sizes

    def check(self) -> None:
        """Check that the files are still in place.

        SQLite shortens none of them, except for a log that another program has moved into the
        journal by a checkpoint.

        :raises JournalUnusable: another program removed, replaced or cut a file
        """
        folder = os.stat(self._folder)  # noqa: PTH116 - a Path takes twice as long
        state = folder.st_dev, folder.st_ino, folder.st_ctime_ns
        sizes = self._sizes_now()
        if state != self._proven or any(map(lt, sizes, self._sizes)):
            self._check_names(sizes)
            self._trust(state)
        self._sizes = sizes

    def release(self) -> None:
        """Note that the files are closed; this process may open them in another way."""
        for file in self._files:
            file.file.close()
        no_longer_written(self._path)

    def _sizes_now(self) -> list[int]:
        return [os.lseek(descriptor, 0, os.SEEK_END) for descriptor in self._descriptors]

    def _check_names(self, sizes: Sequence[int]) -> None:
        for journal_file, size, known in zip(self._files, sizes, self._sizes, strict=True):
            how = self._what_happened(journal_file, size, known)
            if how:
                raise JournalUnusable(
                    f'{Path(journal_file.name).name} was {how} by another program; '
                    'the last events may be lost'
                )

    def _what_happened(self, journal_file: _Opened, size: int, known: int) -> str:
        """Return what another program did with a file; empty: nothing relevant."""
        try:
            status = os.stat(journal_file.name)  # noqa: PTH116 - a Path takes twice as long
        except FileNotFoundError:
            return 'removed'
        if (status.st_dev, status.st_ino) != journal_file.identity:
            return 'replaced'
        is_cut = size < known and not (journal_file.name == self._log and size >= self._log_size())
        return 'cut' if is_cut else ''

    def _trust(self, state: tuple[int, int, int]) -> None:
        """Take the state of the folder as a proof once the names were seen long after it."""
        now = time.monotonic()
        if state != self._found:
            self._found, self._since = state, now
        settled_s = SETTLED_S if state[-1] % 10_000_000 else SETTLED_COARSE_S
        self._proven = state if now - self._since > settled_s else None
