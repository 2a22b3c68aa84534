"""The files that a journal is written to: they have to stay those of that name."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from bt_orchestrator.errors import JournalUnusable
from bt_orchestrator.store.sqlite.database import is_written, log_of, no_longer_written


class _Seen(NamedTuple):
    """What the file system calls a file, and how long it is."""

    device: int
    inode: int
    size: int


class FilesInUse:
    """A journal, its log and the index of that. From here on until `release` they are written.

    SQLite goes on with files that were removed, replaced or cut, and commits what nobody finds.
    """

    def __init__(self, path: Path, log_size: Callable[[], int]) -> None:
        """Look at the files.

        :param log_size: tells how many bytes of the log SQLite relies on
        """
        self._path = path.resolve()
        self._log = log = log_of(self._path)
        self._log_size = log_size
        index = log.with_name(f'{self._path.name}-shm')
        self._known = {file: _seen(file) for file in (self._path, log, index)}
        is_written(self._path)

    def check(self) -> None:
        """See that what was written can be found.

        SQLite makes none of them shorter, but for a log that another program has emptied with its
        help into the journal.

        :raises JournalUnusable: another program took a file away, or cut it
        """
        for file, known in self._known.items():
            found = _seen(file)
            if found == known:
                continue
            if known is not None:  # otherwise SQLite makes it when it needs it
                how = self._how(file, found, known)
                if how:
                    raise JournalUnusable(
                        f'{file.name} was {how} by another program; the last events may be lost'
                    )
            self._known[file] = found

    def release(self) -> None:
        """Let this process open the files in another way; they are closed."""
        no_longer_written(self._path)

    def _how(self, file: Path, found: _Seen | None, known: _Seen) -> str:
        """Return what was done to a file; empty: nothing that matters."""
        if found is None:
            return 'removed'
        if found[:2] != known[:2]:
            return 'replaced'
        if found.size >= known.size or (file == self._log and found.size >= self._log_size()):
            return ''
        return 'cut'


def _seen(file: Path) -> _Seen | None:
    """Look at a file; None: it is not there."""
    try:
        found = file.stat()
    except FileNotFoundError:
        return None
    return _Seen(found.st_dev, found.st_ino, found.st_size)
