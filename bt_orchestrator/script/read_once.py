"""Files that are read again only when they have changed."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TypeVar

from bt_orchestrator.base.errors import Refused

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
        found = {path: known for path in paths if (known := self._one(path)) is not None}
        self._known = found
        return [one.says for one in found.values() if one.says is not None]

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
