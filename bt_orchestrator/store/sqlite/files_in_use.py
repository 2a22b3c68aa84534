"""Detects that the files of a journal were removed, replaced or cut while in use."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from bt_orchestrator.errors import JournalUnusable
from bt_orchestrator.store.sqlite.database import is_written, log_of, no_longer_written

_Seen = tuple[int, int, int]
"""Device, inode and size of a file."""


class FilesInUse:
    """A journal, its log and the log's index; in use until `release`.

    SQLite goes on with files that were removed, replaced or cut, and its commits are lost.
    """

    def __init__(self, path: Path, log_size: Callable[[], int]) -> None:
        """Record the present files.

        :param log_size: returns how many bytes of the log SQLite uses
        """
        self._path = path.resolve()
        self._log = log = log_of(self._path)
        self._log_size = log_size
        index = log.with_name(f'{self._path.name}-shm')
        files = (self._path, log, index)
        self._known = {str(file): _seen(str(file)) for file in files}
        is_written(self._path)

    def check(self) -> None:
        """Check that the files are still in place.

        SQLite shortens none of them, except for a log that another program has moved into the
        journal by a checkpoint.

        :raises JournalUnusable: another program removed, replaced or cut a file
        """
        for file, known in self._known.items():
            found = _seen(file)
            if found == known:
                continue
            if known is not None:  # otherwise SQLite creates it when needed
                how = self._how(file, found, known)
                if how:
                    raise JournalUnusable(
                        f'{Path(file).name} was {how} by another program; '
                        'the last events may be lost'
                    )
            self._known[file] = found

    def release(self) -> None:
        """Note that the files are closed; this process may open them in another way."""
        no_longer_written(self._path)

    def _how(self, file: str, found: _Seen | None, known: _Seen) -> str:
        """Return what happened to a file; empty: nothing relevant."""
        if found is None:
            return 'removed'
        if found[:2] != known[:2]:
            return 'replaced'
        size = found[-1]
        if size >= known[-1] or (file == str(self._log) and size >= self._log_size()):
            return ''
        return 'cut'


def _seen(file: str) -> _Seen | None:
    """Read the state of a file, six times per commit; None: it does not exist."""
    try:
        found = os.stat(file)  # noqa: PTH116 - a Path takes twice as long
    except FileNotFoundError:
        return None
    return found.st_dev, found.st_ino, found.st_size
