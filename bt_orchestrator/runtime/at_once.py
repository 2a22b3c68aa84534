"""A writer that writes in the caller's thread."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

_T = TypeVar('_T')


class AtOnce:
    """Writes before it returns: in virtual time nothing waits. Implements `ports.Writer`."""

    def begin(self, write: Callable[[], _T]) -> Written[_T]:
        """Write."""
        return Written(write)


class Written(Generic[_T]):
    """A completed write, or its error. Implements `ports.Writing`."""

    def __init__(self, write: Callable[[], _T]) -> None:
        """Write; what is raised is kept for `result`."""
        self._failure: Exception | None = None
        try:
            self._result = write()
        except Exception as error:  # noqa: BLE001 - raised again in `result`
            self._failure = error

    def has_ended(self, within_s: float = 0.0) -> bool:  # noqa: ARG002 - it never waits
        """Return True."""
        return True

    def result(self) -> _T:
        """Return what the write returned, or raise what it raised."""
        if self._failure is not None:
            raise self._failure
        return self._result
