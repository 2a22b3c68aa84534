"""Waits for the journal: by the caller's thread, or by separate threads (decision 0029)."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import partial
from queue import SimpleQueue
from typing import Any, Generic, TypeVar

from bt_orchestrator.base.errors import JournalUnusable
from bt_orchestrator.base.replies import Reply

_T = TypeVar('_T')

MOST_READINGS = 50
"""Readings that wait for a journal which does not answer."""


class WritesAtOnce:
    """Writes before it returns: in virtual time nothing waits. Implements `ports.Writer`."""

    def begin(self, write: Callable[[], _T]) -> Written[_T]:
        """Write."""
        written = Written(write)
        written.run()
        return written

    def reaches_disk(self) -> None:
        """Do nothing: what is written is not waited for."""


class WriterThread:
    """Writes in a separate thread, in order. Implements `ports.Writer`.

    The thread never delays the end of the process: one that hangs in a write is abandoned.
    """

    def __init__(self, wake: Callable[[], None]) -> None:
        """Start the thread.

        :param wake: called in the thread when a write has ended that was waited for
        """
        self._wake = wake
        self._todo: SimpleQueue[Writing[Any] | None] = SimpleQueue()
        self._present: Writing[Any] | None = None
        self._thread = threading.Thread(target=self._run, name='journal', daemon=True)
        self._thread.start()

    def reaches_disk(self) -> None:
        """Note that only the disk still works on the present write; called by that write."""
        if self._present is not None:
            self._present.reach_disk()

    def begin(self, write: Callable[[], _T]) -> Writing[_T]:
        """Queue a write after all earlier ones."""
        writing = Writing(write, self._wake)
        self._todo.put(writing)
        return writing

    def close(self, within_s: float) -> bool:
        """End after the queued writes; return whether that was in time."""
        self._todo.put(None)
        self._thread.join(within_s)
        return not self._thread.is_alive()

    def _run(self) -> None:
        while (writing := self._todo.get()) is not None:
            self._present = writing
            writing.run()


class Readings:
    """Reads a journal in a separate thread, in order, and hands the results to the tick thread.

    A database, or a disk, may take long. Implements `ports.Worker`.
    """

    def __init__(self, soon: Callable[[Callable[[], None]], None]) -> None:
        """Start the thread.

        :param soon: lets the tick thread call something; called by another thread
        """
        self._soon = soon
        self._thread = WriterThread(_nobody)
        self._waiting = 0
        self.begin = self._thread.begin
        self.close = self._thread.close

    async def result_of(self, read: Callable[[], _T]) -> _T:
        """Read, and return the result once it is there, or raise its error.

        :raises JournalUnusable: too many wait already
        """
        if self._waiting >= MOST_READINGS:
            raise JournalUnusable(
                f'the journal does not answer: {MOST_READINGS} readings wait; ask again later'
            )
        ended: Reply[Written[_T]] = Reply()
        self._waiting += 1
        self._thread.begin(partial(self._read, read, ended))
        reading = await ended
        self._waiting -= 1
        return reading.result()

    def _read(self, read: Callable[[], _T], ended: Reply[Written[_T]]) -> None:
        reading = Written(read)
        reading.run()
        self._soon(partial(ended.give, reading))


class Written(Generic[_T]):
    """A write that runs before it is asked for. Implements `ports.Writing`."""

    def __init__(self, write: Callable[[], _T]) -> None:
        self._write = write
        self._failure: Exception | None = None

    def run(self) -> None:
        """Write; what is raised is kept for `result`."""
        try:
            self._result = self._write()
        except Exception as error:  # noqa: BLE001 - raised again in `result`
            self._failure = error

    def is_at_disk(self, within_s: float) -> bool:  # noqa: ARG002
        """Return False: it has ended."""
        return False

    def has_ended(self, within_s: float = 0.0) -> bool:  # noqa: ARG002
        """Return True."""
        return True

    def result(self) -> _T:
        """Return the result of the write, or raise its error."""
        if self._failure is not None:
            raise self._failure
        return self._result


class Writing(Written[_T]):
    """A write by one thread, which another thread waits for."""

    def __init__(self, write: Callable[[], _T], wake: Callable[[], None]) -> None:
        super().__init__(write)
        self._wake = wake
        self._under_way = threading.Lock()
        self._under_way.acquire()
        self._before_disk = threading.Lock()
        self._before_disk.acquire()
        self._has_ended = False
        self._is_late = False
        """The waiting thread has seen that it has not ended."""

    def run(self) -> None:
        """Write; what is raised is kept for `result`."""
        super().run()
        self._under_way.release()
        self.reach_disk()
        if self._is_late:
            self._wake()

    def reach_disk(self) -> None:
        """Note that the writing thread has nothing left to do but to wait."""
        if self._before_disk.locked():
            self._before_disk.release()

    def has_ended(self, within_s: float = 0.0) -> bool:
        """Tell whether it has ended, successfully or not; wait at most `within_s` for that."""
        if not self._has_ended:
            self._has_ended = self._under_way.acquire(timeout=within_s)
        if not self._has_ended:
            self._is_late = True  # from now on its end wakes; it may have ended just before
            self._has_ended = self._under_way.acquire(blocking=False)
        return self._has_ended

    def is_at_disk(self, within_s: float) -> bool:
        """Tell whether the disk alone works on it; wait at most `within_s` for that or its end."""
        if self._has_ended or not self._before_disk.acquire(timeout=within_s):
            return False
        self._has_ended = self._under_way.acquire(blocking=False)
        return not self._has_ended

    def result(self) -> _T:
        """Return the result of the write, or raise its error."""
        assert self._has_ended, 'it has not ended'
        return super().result()


def _nobody() -> None:
    """Placeholder for the wake function while no thread waits."""
