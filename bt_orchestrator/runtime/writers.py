"""Who waits for the disk: the caller, or a thread of its own (decision 0029)."""

from __future__ import annotations

import threading
from collections.abc import Callable
from queue import SimpleQueue
from typing import Any, Generic, TypeVar

_T = TypeVar('_T')


class AtOnce:
    """Writes before it returns: in virtual time nothing waits. Implements `ports.Writer`."""

    def begin(self, write: Callable[[], _T]) -> Writing[_T]:
        """Write."""
        writing = Writing(write, _nobody)
        writing.run()
        return writing


class WriterThread:
    """Writes in a thread of its own, one thing after the other. Implements `ports.Writer`.

    The thread ends no process late: one that hangs in a write to a dead disk is left behind.
    """

    def __init__(self, wake: Callable[[], None]) -> None:
        """Start the thread.

        :param wake: called in the thread when something has ended that was waited for
        """
        self._wake = wake
        self._todo: SimpleQueue[Writing[Any] | None] = SimpleQueue()
        self._thread = threading.Thread(target=self._run, name='journal', daemon=True)
        self._thread.start()

    def begin(self, write: Callable[[], _T]) -> Writing[_T]:
        """Have something written after all that was begun before."""
        writing = Writing(write, self._wake)
        self._todo.put(writing)
        return writing

    def close(self, within_s: float) -> bool:
        """End after what was begun; tell whether it did so in time."""
        self._todo.put(None)
        self._thread.join(within_s)
        return not self._thread.is_alive()

    def _run(self) -> None:
        while (writing := self._todo.get()) is not None:
            writing.run()


class Writing(Generic[_T]):
    """Something to be written, by one thread, and waited for by another.

    Implements `ports.Writing`.
    """

    def __init__(self, write: Callable[[], _T], wake: Callable[[], None]) -> None:
        self._write = write
        self._wake = wake
        self._under_way = threading.Lock()
        self._under_way.acquire()
        self._has_ended = False
        self._is_late = False
        """Whoever waits was told that it has not ended."""
        self._failure: Exception | None = None

    def run(self) -> None:
        """Write; what is raised is kept for `result`."""
        try:
            self._result = self._write()
        except Exception as error:  # noqa: BLE001 - raised again in `result`
            self._failure = error
        self._under_way.release()
        if self._is_late:
            self._wake()

    def has_ended(self, within_s: float = 0.0) -> bool:
        """Tell whether it has ended, well or not; wait for that for so long at most."""
        if not self._has_ended:
            self._has_ended = self._under_way.acquire(timeout=within_s)
        if not self._has_ended:
            self._is_late = True  # from here on it wakes; it may have ended just before
            self._has_ended = self._under_way.acquire(blocking=False)
        return self._has_ended

    def result(self) -> _T:
        """Return what the write returned, or raise what it raised."""
        assert self._has_ended, 'it has not ended'
        if self._failure is not None:
            raise self._failure
        return self._result


def _nobody() -> None:
    """Stand for whoever would be woken: nobody waits."""
