"""The high-water mark: how far a node has written a journal, in a file on its own disk.

After damage, SQLite may show a journal that seems complete but ends earlier. So does a replica of
PostgreSQL that was promoted before it had the last events. The mark is rewritten after each
commit, so it is ahead of the journal only if the journal has lost events.
"""

from __future__ import annotations

import logging
import os
import re
import zlib
from datetime import datetime, timezone
from pathlib import Path
from typing import NamedTuple

log = logging.getLogger(__name__)

PRIVATE = 0o600
"""Mode of the files of a journal: owner only. SQLite gives its log the same mode."""

MARK = '-mark'
"""Ends the name of a mark, which begins with that of its journal.

A mark exists at every moment, so a missing journal is detected.
"""

MOST = 4096
"""Bytes read of a mark; it has about a hundred."""

_LINE = re.compile(
    rb'(bt_orchestrator mark 1 (\w{1,64}) (\d{20}) (-?\d{1,15}\.\d{6})) ([0-9a-f]{8})\n'
)


class Reached(NamedTuple):
    """The content of a mark."""

    history: str
    seq: int
    """The last event that was written."""
    time: float
    """When that event happened, seconds since the epoch."""


class Mark:
    """States: only read, written (from `write` on), closed."""

    def __init__(self, journal: Path) -> None:
        """Read the mark of a journal; nothing is created or changed."""
        self.path = mark_of(journal)
        self._file: int | None = None
        self._failed = False
        self.found = read_mark(self.path)
        """Its content before it was written; None: there was none, or it cannot be read."""

    def write(self, reached: Reached) -> None:
        """Note how far the journal is written; a few microseconds, and no fsync.

        A mark that is behind after a power cut does no harm. A mark that cannot be written only
        weakens later checks, so it stops nothing.
        """
        if self._failed:
            return
        try:
            if self._file is None:
                self._file = _opened(self.path)
            os.pwrite(self._file, _line(reached), 0)
        except OSError as error:
            self._failed = True
            log.warning('%s cannot be written (%s): %s', self.path, error.strerror, _UNNOTICED)

    def sync(self) -> None:
        """Sync what was written to disk, file and name."""
        if self._file is None:
            return
        try:
            if not _is_at(self._file, self.path):
                log.warning('%s was taken away, and is made again', self.path)
                last = os.pread(self._file, MOST, 0)
                os.close(self._file)
                self._file = None
                self._file = _opened(self.path)
                os.pwrite(self._file, last, 0)
            os.fsync(self._file)
        except OSError as error:
            log.warning('%s cannot be written (%s): %s', self.path, error.strerror, _UNNOTICED)

    def close(self) -> None:
        """Sync it to disk, and close it."""
        self.sync()
        if self._file is not None:
            os.close(self._file)
            self._file = None


_UNNOTICED = 'that events are missing would not be noticed'


def mark_of(journal: Path) -> Path:
    """Return the path of the mark beside a journal."""
    real = journal.resolve()
    return real.with_name(f'{real.name}{MARK}')


def read_mark(path: Path) -> Reached | None:
    """Return what a mark says; None, with a warning, if it cannot be read."""
    try:
        file = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
        try:
            text = os.read(file, MOST)
        finally:
            os.close(file)
    except FileNotFoundError:
        return None
    except OSError as error:
        log.warning('%s cannot be read (%s): %s', path, error.strerror, _UNNOTICED)
        return None
    match = _LINE.match(text)
    if match is None or zlib.crc32(match[1]) != int(match[5], 16):
        log.warning('%s is damaged, and is made again: %s', path, _UNNOTICED)
        return None
    return Reached(match[2].decode(), int(match[3]), float(match[4]))


def write_mark(path: Path, reached: Reached) -> None:
    """Create a mark; it is on disk on return.

    :raises OSError: it cannot be created
    """
    file = _opened(path)
    try:
        os.pwrite(file, _line(reached), 0)
        os.fsync(file)
    finally:
        os.close(file)


def _line(reached: Reached) -> bytes:
    text = f'bt_orchestrator mark 1 {reached.history} {reached.seq:020d} {reached.time:.6f}'
    return b'%s %08x\n' % (text.encode(), zlib.crc32(text.encode()))


def _opened(path: Path) -> int:
    return os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, PRIVATE)


def _is_at(file: int, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(file), path.stat())
    except FileNotFoundError:
        return False


def shortfall(mark: Mark, history: str, last_row: int, read: int) -> str:
    """Say what was written and is lost; empty: nothing, as far as is known.

    :param history: id of the journal's history
    :param last_row: the last event that has a row, damaged or not
    :param read: the event up to which the journal could be read
    """
    reached = mark.found
    if reached is not None and reached.history != history:
        return (
            f'{mark.path.name} is of another journal (history {reached.history}), which was '
            f'written here up to event {reached.seq} of {_utc(reached.time)}: the journal was '
            'replaced, or the mark was'
        )
    marked = reached.seq if reached is not None else 0
    number = max(marked, last_row) - read
    if number <= 0:
        return ''
    what = f'{number} event{"s are" if number > 1 else " is"} missing'
    if last_row > read:
        return f'{what}: a record after event {read} is damaged, or it is not there'
    assert reached is not None
    return f'{what}: event {reached.seq} of {_utc(reached.time)} had been written'


def _utc(seconds: float) -> str:
    try:
        moment = datetime.fromtimestamp(seconds, timezone.utc)
    except (OverflowError, ValueError, OSError):
        return f'{seconds:g} s'
    return f'{moment:%Y-%m-%d %H:%M:%S} UTC'
