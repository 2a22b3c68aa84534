"""Readers of the page's stream that are no browsers: those that read, and those that are stuck."""

from __future__ import annotations

import json
import socket
import threading
import time
from http.client import HTTPConnection
from typing import Any

from patience import PATIENCE_S

_REQUEST = b'GET /api/stream HTTP/1.1\r\nHost: 127.0.0.1:%d\r\n\r\n'


class StreamReader:
    """Reads the stream in a thread of its own until `close`.

    :ivar numbers: of the events that came, in order
    :ivar delays_s: from the time of each event to its arrival here
    """

    def __init__(self, port: int) -> None:
        self.numbers: list[int] = []
        self.delays_s: list[float] = []
        self.has_begun = threading.Event()
        self._connection = HTTPConnection('127.0.0.1', port, timeout=PATIENCE_S)
        self._connection.request('GET', '/api/stream')
        self._response = self._connection.getresponse()
        assert self._response.status == 200
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def wait_begun(self) -> None:
        """Wait until the page has told where the events begin."""
        assert self.has_begun.wait(PATIENCE_S), 'the stream never began'

    @property
    def last(self) -> int:
        """Number of the last event that came."""
        return self.numbers[-1] if self.numbers else 0

    def close(self) -> None:
        """Leave."""
        if self._connection.sock is not None:
            self._connection.sock.shutdown(socket.SHUT_RDWR)
        self._thread.join(PATIENCE_S)
        self._connection.close()

    def _read(self) -> None:
        kind = ''
        try:
            for line in self._response:
                name, _, value = line.decode().rstrip('\n').partition(': ')
                if name == 'event':
                    kind = value
                elif name == 'data':
                    self._take(kind, json.loads(value))
        except (OSError, ValueError):
            pass  # closed, or the page is gone

    def _take(self, kind: str, data: Any) -> None:
        if kind == 'begin':
            self.has_begun.set()
        if kind == 'happened':
            now = time.time()
            for record in data['records']:
                self.numbers.append(record['seq'])
                self.delays_s.append(now - record['time'])


class StuckReader:
    """Asks for the stream, and takes nothing of it."""

    def __init__(self, port: int) -> None:
        self._socket = socket.socket()
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        self._socket.settimeout(PATIENCE_S)
        self._socket.connect(('127.0.0.1', port))
        self._socket.sendall(_REQUEST % port)

    def close(self) -> None:
        """Leave."""
        self._socket.close()
