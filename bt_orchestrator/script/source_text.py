"""Reading a user's file as text, and again only when it has changed."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

from bt_orchestrator.base.errors import Finding, Refused
from bt_orchestrator.base.ordinary_file import NotOrdinary, open_ordinary
from bt_orchestrator.script.report import START, did_you_mean

ENDINGS = ('.yaml', '.yml')
"""Of files that people write for this program."""

LARGEST_FILE = 4_000_000
"""Bytes; a script of 2,000 tasks has about 250,000."""


def read_text(path: Path) -> str:
    """Return the text of a file; never blocks on a pipe.

    :raises Refused: it is no ordinary file, cannot be read, is too large, or is not UTF-8
    """
    try:
        with open_ordinary(path) as file:
            data = file.read(LARGEST_FILE + 1) or b''
    except FileNotFoundError:
        raise _refused(path, 'the file does not exist', _neighbour(path)) from None
    except IsADirectoryError:
        raise _refused(path, 'this is a directory', 'name the YAML file in it') from None
    except NotOrdinary as fault:
        raise _refused(path, str(fault.strerror), 'save it as a file') from None
    except (OSError, ValueError) as fault:
        reason = getattr(fault, 'strerror', None) or str(fault)
        what = f'the file cannot be read: {reason}'
        raise _refused(path, what, 'check the path and its permissions') from None
    if len(data) > LARGEST_FILE:
        megabytes = LARGEST_FILE // 1_000_000
        raise _refused(path, f'the file is larger than {megabytes} MB', 'is this the right file?')
    return _decoded(data, path)


def _decoded(data: bytes, path: Path) -> str:
    try:
        return data.decode('utf-8')
    except UnicodeDecodeError as fault:
        before = data[: fault.start]
        line = before.count(b'\n') + 1
        column = len(before[before.rfind(b'\n') + 1 :].decode('utf-8')) + 1
        what = 'the file is not UTF-8 text'
        finding = Finding(str(path), line, column, what, 'save it as UTF-8')
        raise Refused([finding]) from None


def _neighbour(path: Path) -> str:
    """Offer the YAML file nearby that is most like the one asked for."""
    try:
        names = sorted(
            neighbour.name for neighbour in path.parent.iterdir() if neighbour.suffix in ENDINGS
        )
    except OSError:
        return f'there is no folder {path.parent} either'
    return did_you_mean(path.name, names, 'check the path')


def _refused(path: Path, what: str, hint: str) -> Refused:
    return Refused([Finding(str(path), START.line, START.column, what, hint)])


# Files that are read again only when they have changed.

T = TypeVar('T')


class ReadOnce(Generic[T]):
    """The content of some files; a file of the same time of change and size is not read again."""

    def __init__(self, read: Callable[[Path], T]) -> None:
        """Prepare; nothing is read.

        :param read: raises Refused where a file says nothing of the kind
        """
        self._read = read
        self._known: dict[Path, _Known[T]] = {}

    def of(self, paths: Iterable[Path]) -> list[T]:
        """Return what the files say, in their order; those that cannot be read are left out.

        Those that are not among them are forgotten.
        """
        files = {path: known for path in paths if (known := self._one(path)) is not None}
        self._known = files
        return [file.says for file in files.values() if file.says is not None]

    def _one(self, path: Path) -> _Known[T] | None:
        try:
            about = path.stat()
        except OSError:
            return None
        stamp = (about.st_mtime_ns, about.st_size)
        known = self._known.get(path)
        if known is not None and known.stamp == stamp:
            return known
        try:
            return _Known(stamp, self._read(path))
        except Refused:
            return _Known(stamp, None)


@dataclass(frozen=True)
class _Known(Generic[T]):
    stamp: tuple[int, int]
    says: T | None
    """None: nothing of the kind."""
