"""SIGINT and SIGTERM as a stop request, also while the main thread waits in the middleware."""

from __future__ import annotations

import signal
import socket
import threading
from collections.abc import Callable
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
