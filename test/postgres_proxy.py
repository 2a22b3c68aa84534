"""A proxy before a PostgreSQL server that loses what a network loses, at a chosen message."""

from __future__ import annotations

import re
import socket
import struct
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path

_READS = re.compile(rb'\0SELECT [^;]* FROM (events|history)\b')


class Proxy:
    """Passes connections on. Each fault happens once, to the next statement."""

    def __init__(self, folder: Path, server: Path) -> None:
        """Listen on a socket as a server does.

        :param folder: where its socket is to be
        :param server: folder of the socket of the server
        """
        self.server = server
        """Where connections lead; another one takes its place after a promotion."""
        self._listening = socket.socket(socket.AF_UNIX)
        self._listening.bind(str(folder / '.s.PGSQL.5432'))
        self._listening.listen()
        self.loses_answer = threading.Event()
        """The server carries a statement out, and its answer is lost."""
        self.loses_commit = threading.Event()
        """The server answers a statement, and does not hear that this was all: no commit."""
        self.happened = threading.Event()
        self.slow_reading_s = 0.0
        """How long each statement takes longer that only reads the journal."""
        threading.Thread(target=self._accept, daemon=True).start()

    def close(self) -> None:
        self._listening.close()

    def _accept(self) -> None:
        with suppress(OSError):
            while True:
                client, _ = self._listening.accept()
                server = socket.socket(socket.AF_UNIX)
                try:
                    server.connect(str(self.server / '.s.PGSQL.5432'))
                except OSError:  # it does not run
                    server.close()
                    client.close()
                else:
                    _Passing(self, client, server).start()


class _Passing:
    def __init__(self, proxy: Proxy, client: socket.socket, server: socket.socket) -> None:
        self._proxy, self._client, self._server = proxy, client, server
        self._fault: threading.Event | None = None
        self._parsed: dict[bytes, bytes] = {}
        """Statements that the server has read, by name."""

    def start(self) -> None:
        for work in (self._up, self._down):
            threading.Thread(target=self._until_it_ends, args=(work,), daemon=True).start()

    def _until_it_ends(self, work: object) -> None:
        assert callable(work)
        with suppress(OSError, EOFError):
            work()
        for peer in (self._client, self._server):
            with suppress(OSError):
                peer.shutdown(socket.SHUT_RDWR)
            peer.close()

    def _up(self) -> None:
        (size,) = struct.unpack('!I', _exactly(self._client, 4))
        self._server.sendall(struct.pack('!I', size) + _exactly(self._client, size - 4))
        while True:
            kind, message = _message(self._client)
            if kind == b'P':
                self._parsed[_names(message)[0]] = message
            if kind == b'B' and self._is_append(message):
                for fault in (self._proxy.loses_answer, self._proxy.loses_commit):
                    if fault.is_set():
                        self._fault = fault
            elif kind == b'P' and _READS.search(message):
                time.sleep(self._proxy.slow_reading_s)  # as a busy server does
            if kind == b'S' and self._fault is self._proxy.loses_commit:
                message = b'H' + message[1:]  # flush instead of sync
            self._server.sendall(message)

    def _is_append(self, message: bytes) -> bool:
        """Tell whether a message carries out a statement that writes events."""
        return b'INSERT INTO events' in self._parsed[_names(message)[1]]

    def _down(self) -> None:
        while True:
            kind, message = _message(self._server)
            if self._fault is self._proxy.loses_answer:
                if kind == b'Z':
                    self._end()
                continue
            self._client.sendall(message)
            if kind == b'C' and self._fault is not None:
                self._end()

    def _end(self) -> None:
        assert self._fault is not None
        self._fault.clear()
        self._proxy.happened.set()
        raise EOFError


def _names(message: bytes) -> list[bytes]:
    """Return the texts that a message begins with."""
    return message[5:].split(b'\0')


def _message(source: socket.socket) -> tuple[bytes, bytes]:
    head = _exactly(source, 5)
    return head[:1], head + _exactly(source, struct.unpack('!I', head[1:])[0] - 4)


def _exactly(source: socket.socket, number: int) -> bytes:
    data = b''
    while len(data) < number:
        part = source.recv(number - len(data))
        if not part:
            raise EOFError
        data += part
    return data


@contextmanager
def through(address: str, server: Path) -> Iterator[tuple[str, Proxy]]:
    """Put a proxy before a server, and give the address that leads through it.

    :param server: folder of the socket of the server
    """
    # Not in a folder of pytest: names of sockets are short.
    with (
        tempfile.TemporaryDirectory() as folder,
        closing(Proxy(Path(folder), server)) as proxy,
    ):
        yield address.replace(str(server), folder), proxy
