"""The files that a journal is written to: they have to stay those of that name."""

from __future__ import annotations

from pathlib import Path

from bt_orchestrator.store.database import JournalUnusable, is_written, log_of, no_longer_written


class FilesInUse:
    """A journal and its log, told by what they are. From here on until `release` they are written.

    SQLite goes on with files that were removed or replaced, and commits what nobody will find.
    """

    def __init__(self, path: Path) -> None:
        self._path = path.resolve()
        self._known = {file: _identity(file) for file in (self._path, log_of(self._path))}
        is_written(self._path)

    def check(self) -> None:
        """See that what was written can be found.

        :raises JournalUnusable: another program took a file away
        """
        for file, known in self._known.items():
            found = _identity(file)
            if known is None:
                self._known[file] = found  # SQLite makes it when it needs it
            elif found != known:
                how = 'removed' if found is None else 'replaced'
                raise JournalUnusable(
                    f'{file.name} was {how} by another program; the last events may be lost'
                )

    def release(self) -> None:
        """Let this process open the files in another way; they are closed."""
        no_longer_written(self._path)


def _identity(file: Path) -> tuple[int, int] | None:
    """Return what the file system calls a file; None: it is not there."""
    try:
        found = file.stat()
    except FileNotFoundError:
        return None
    return found.st_dev, found.st_ino
