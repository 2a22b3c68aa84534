"""The files that a journal is written to: they have to stay those of that name."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from bt_orchestrator.errors import JournalUnusable
from bt_orchestrator.store.sqlite.database import is_written, log_of, no_longer_written

_Seen = tuple[int, int, int]
"""What the file system calls a file, by device and inode, and how long it is."""


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
        files = (self._path, log, index)
        self._known = {str(file): _seen(str(file)) for file in files}
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
                        f'{Path(file).name} was {how} by another program; '
                        'the last events may be lost'
                    )
            self._known[file] = found

    def release(self) -> None:
        """Let this process open the files in another way; they are closed."""
        no_longer_written(self._path)

    def _how(self, file: str, found: _Seen | None, known: _Seen) -> str:
        """Return what was done to a file; empty: nothing that matters."""
        if found is None:
            return 'removed'
        if found[:2] != known[:2]:
            return 'replaced'
        size = found[-1]
        if size >= known[-1] or (file == str(self._log) and size >= self._log_size()):
            return ''
        return 'cut'


def _seen(file: str) -> _Seen | None:
    """Look at a file, six times a commit; None: it is not there."""
    try:
        found = os.stat(file)  # noqa: PTH116 - a Path takes twice as long
    except FileNotFoundError:
        return None
    return found.st_dev, found.st_ino, found.st_size
