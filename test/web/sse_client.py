"""A reader of the stream, for tests: `http.client`, one message after the other."""

from __future__ import annotations

import http.client
import json
import time
from collections.abc import Callable
from typing import Any, NamedTuple

from patience import PATIENCE_S


class Message(NamedTuple):
    """One message of the stream."""

    kind: str
    id: str
    data: dict[str, Any]


class SseClient:
    """One open stream. A context."""

    def __init__(self, port: int, after: str = '', last_event_id: str = '') -> None:
        self._connection = http.client.HTTPConnection('127.0.0.1', port, timeout=PATIENCE_S)
        headers = {'Last-Event-ID': last_event_id} if last_event_id else {}
        self._connection.request('GET', f'/api/stream?after={after}', headers=headers)
        self.response = self._connection.getresponse()
        self.comments = 0

    def __enter__(self) -> SseClient:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def close(self) -> None:
        """Leave."""
        self.response.close()
        self._connection.close()

    def next(self) -> Message | None:
        """Return the next message; None: the stream has ended."""
        fields: dict[str, str] = {}
        while line := self.response.readline().decode().rstrip('\n'):
            name, _, value = line.partition(': ')
            self.comments += line.startswith(':')
            fields[name] = value
        if not fields:
            return None
        if 'event' not in fields:
            return self.next()
        return Message(fields['event'], fields.get('id', ''), json.loads(fields['data']))

    def until(self, wanted: Callable[[Message], object], within_s: float = PATIENCE_S) -> Message:
        """Return the first message that is wanted."""
        deadline = time.monotonic() + within_s
        while time.monotonic() < deadline:
            message = self.next()
            assert message is not None, 'the stream has ended'
            if wanted(message):
                return message
        raise AssertionError(f'no such message within {within_s:g} s')

    def first(self, kind: str) -> Message:
        """Return the next message of a kind."""
        return self.until(lambda message: message.kind == kind)

    def seqs(self, last: int) -> list[int]:
        """Return the numbers of events that come next, up to one."""
        numbers: list[int] = []
        while not numbers or numbers[-1] < last:
            message = self.until(lambda event: event.kind in ('happened', 'gap'))
            if message.kind == 'gap':
                numbers += range(-message.data['first'], -message.data['last'] - 1, -1)
            else:
                numbers += [record['seq'] for record in message.data['records']]
        return numbers
