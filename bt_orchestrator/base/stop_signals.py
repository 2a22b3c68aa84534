"""SIGINT and SIGTERM as a stop request, and a limit for the last thing that a process does."""

from __future__ import annotations

import faulthandler
import signal
import socket
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


class StopSignals:
    """A context in which stop signals set a request instead of ending the process.

    Python runs signal handlers in the main thread, but not while it waits in a library; so a
    separate thread reads what the interpreter writes at every signal. Enter it in the main thread.
    """

    def __init__(self) -> None:
        self.count = 0
        """Number of stop signals received."""
        self._wake: Callable[[], object] = _nothing

    def __enter__(self) -> StopSignals:
        self._reader, self._writer = socket.socketpair()
        self._writer.setblocking(False)
        self._old_fd = signal.set_wakeup_fd(self._writer.fileno(), warn_on_full_buffer=False)
        self._old_handlers = [signal.signal(number, _noted) for number in _SIGNALS]
        self._thread = threading.Thread(target=self._listen, name='stop signals')
        self._thread.start()
        return self

    def __exit__(self, *exception: object) -> None:
        for number, handler in zip(_SIGNALS, self._old_handlers, strict=True):
            signal.signal(number, handler)
        signal.set_wakeup_fd(self._old_fd)
        self._writer.close()
        self._thread.join()
        self._reader.close()

    @property
    def requested(self) -> bool:
        """Whether a stop signal was received."""
        return self.count > 0

    def notify(self, wake: Callable[[], object]) -> None:
        """Set a function to call, in another thread, at a stop signal; at once if one came."""
        self._wake = wake
        if self.requested:
            wake()

    def _listen(self) -> None:
        while written := self._reader.recv(1):
            if written[0] in _SIGNALS:
                self.count += 1
                self._wake()


def _noted(number: int, frame: FrameType | None) -> None:
    """Empty handler: without a handler the interpreter would write nothing."""


def _nothing() -> None:
    """Placeholder until a wake function is set."""


# A limit for the last thing that a process does: to let go of the middleware.

LEAVING_S = 20.0
"""Far more than it ever takes, on a busy machine too."""

_STDERR = 2


@contextmanager
def leaving() -> Iterator[None]:
    """Let go of the middleware in time, or be ended with status 1 and a stack trace on stderr.

    The destructors of a DDS may wait for each other for ever. They may do so while their thread
    holds Python's lock, so no thread of Python can watch over them; faulthandler's is none. What
    is to be written or told must be so before. Only for processes that end: it ends them.
    """
    faulthandler.dump_traceback_later(LEAVING_S, exit=True, file=_STDERR)
    try:
        yield
    finally:
        faulthandler.cancel_dump_traceback_later()
