"""A server at an address, whose loop runs in a thread of its own."""

from __future__ import annotations

import abc
import asyncio
import contextlib
import socket
import threading
from collections.abc import Iterator

from bt_orchestrator.ports.doors.cell_client import CellClient


class ServerThread(abc.ABC):
    """States: bound, running, ended."""

    def __init__(self, program: str, client: CellClient, taken: socket.socket) -> None:
        """Be ready to run.

        :param taken: bound to the address; `_serve` closes it
        """
        self._client = client
        self._socket = taken
        self._stopped = threading.Event()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._error: BaseException | None = None
        self._thread = threading.Thread(target=self._run, name=f'{program}: server', daemon=True)

    @property
    def port(self) -> int:
        """The port that it has."""
        return int(self._socket.getsockname()[1])

    @property
    @abc.abstractmethod
    def address(self) -> str:
        """The answer to a client."""

    @contextlib.contextmanager
    def running(self) -> Iterator[None]:
        """Serve as long as the context is open."""
        self._thread.start()
        try:
            yield
        finally:
            self.stop()
            self._thread.join()
            self._client.join()

    def stop(self) -> None:
        """End it; from any thread."""
        self._stopped.set()
        loop = self._loop
        if loop is not None:
            with contextlib.suppress(RuntimeError):  # it has ended
                loop.call_soon_threadsafe(self._end)

    def wait(self) -> None:
        """Wait until it was stopped, or cannot go on; raises why it cannot."""
        self._stopped.wait()
        error = self._error or self._client.error
        if error is not None:
            raise error

    # --- the thread -------------------------------------------------------------------------

    def _run(self) -> None:
        try:
            asyncio.run(self._serve())
        except BaseException as error:  # noqa: BLE001 - `wait` raises it
            self._error = error
        finally:
            self._stopped.set()

    def _can_end(self) -> None:
        """From now on `_end` may be called; called in the loop."""
        self._loop = asyncio.get_running_loop()
        if self._stopped.is_set():  # before there was a loop to tell
            self._end()

    @abc.abstractmethod
    async def _serve(self) -> None:
        """Serve until `_end` is called; calls `_can_end` as soon as it may be."""

    @abc.abstractmethod
    def _end(self) -> None:
        """Make `_serve` end; called in the loop."""
