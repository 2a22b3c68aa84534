"""Detects that the files of a journal were removed, replaced or cut while in use."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from operator import lt
from pathlib import Path

from bt_orchestrator.base.errors import JournalUnusable
from bt_orchestrator.store.sqlite.database import is_written, log_of, no_longer_written

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
        found = os.fstat(self.file.fileno())
        self.identity = found.st_dev, found.st_ino


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
        self._sizes = [0] * len(self._files)
        self._found: object = None
        """State of the folder at the last look at the names."""
        self._since = 0.0
        """When it was found first, by the steady clock."""
        self._proven: object = None
        """State of the folder that proves that the names are in place; None: none does yet."""
        is_written(self._path)

    def check(self) -> None:
        """Check that the files are still in place.

        SQLite shortens none of them, except for a log that another program has moved into the
        journal by a checkpoint.

        :raises JournalUnusable: another program removed, replaced or cut a file
        """
        folder = os.stat(self._folder)  # noqa: PTH116 - a Path takes twice as long
        state = folder.st_dev, folder.st_ino, folder.st_ctime_ns
        sizes = [one.file.seek(0, os.SEEK_END) for one in self._files]
        if state != self._proven or any(map(lt, sizes, self._sizes)):
            for one, size, known in zip(self._files, sizes, self._sizes, strict=True):
                how = self._what_happened(one, size, known)
                if how:
                    raise JournalUnusable(
                        f'{Path(one.name).name} was {how} by another program; '
                        'the last events may be lost'
                    )
            self._trust(state)
        self._sizes = sizes

    def release(self) -> None:
        """Note that the files are closed; this process may open them in another way."""
        for one in self._files:
            one.file.close()
        no_longer_written(self._path)

    def _what_happened(self, one: _Opened, size: int, known: int) -> str:
        """Return what another program did with a file; empty: nothing relevant."""
        try:
            found = os.stat(one.name)  # noqa: PTH116 - a Path takes twice as long
        except FileNotFoundError:
            return 'removed'
        if (found.st_dev, found.st_ino) != one.identity:
            return 'replaced'
        is_cut = size < known and not (one.name == self._log and size >= self._log_size())
        return 'cut' if is_cut else ''

    def _trust(self, state: tuple[int, int, int]) -> None:
        """Take the state of the folder as a proof once the names were seen long after it."""
        now = time.monotonic()
        if state != self._found:
            self._found, self._since = state, now
        settled_s = SETTLED_S if state[-1] % 10_000_000 else SETTLED_COARSE_S
        self._proven = state if now - self._since > settled_s else None
