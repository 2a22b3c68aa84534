"""Reading a file that somebody named, whatever it turns out to be.

A pipe without a writer, a terminal, or a file that another process has a lease on makes `open`
wait, and a device never ends: so a file is opened without waiting, looked at, and read up to a
limit.
"""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO


class NotOrdinary(OSError):
    """It is a pipe or a device, or larger than it may be; `strerror` says so."""

    def __init__(self, what: str, path: str) -> None:
        super().__init__(errno.EINVAL, what, path)

    def __str__(self) -> str:
        return f'{self.filename}: {self.strerror}'


@contextmanager
def open_ordinary(path: Path) -> Iterator[IO[bytes]]:
    """Open a file for reading.

    :raises NotOrdinary: it is a pipe or a device
    :raises OSError: it cannot be read
    :raises ValueError: no file can have this name
    """
    with open(path, 'rb', opener=_open_at_once) as file:
        if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
            raise NotOrdinary('this is a pipe or a device, and no ordinary file', str(path))
        yield file


def read_up_to(file: IO[bytes], most: int) -> bytes:
    """Return what is in an open file.

    :param most: longest content, bytes
    :raises NotOrdinary: it is longer
    """
    content = file.read(most + 1) or b''
    if len(content) > most:
        raise NotOrdinary(f'the file is larger than {_in_words(most)}', file.name)
    return content


def read_ordinary(path: Path, most: int) -> bytes:
    """Return what is in a file; raises as `open_ordinary` and `read_up_to`."""
    with open_ordinary(path) as file:
        return read_up_to(file, most)


def _in_words(size: int) -> str:
    return f'{size // 1_000_000} MB' if size >= 1_000_000 else f'{size // 1000} kB'


def _open_at_once(path: str, flags: int) -> int:
    return os.open(path, flags | os.O_NONBLOCK | os.O_NOCTTY)
