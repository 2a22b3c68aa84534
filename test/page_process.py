"""The operator page of a node in a process of its own, for tests."""

from __future__ import annotations

import http.client
import json
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from urllib.request import urlopen

from patience import PATIENCE_S
from served_process import PASSWORD, ServedProcess

_LOOK_S = 0.1


class PageProcess(ServedProcess):
    """The page on a port of its own."""

    def __init__(self, folder: Path, node: str, options: Sequence[str] = ()) -> None:
        """Start it; `wait_ready` waits for it.

        :param options: of the verb, on top of node, port and users
        """
        super().__init__(folder, 'page', node, options)

    @property
    def readers(self) -> int:
        """How many streams it has open."""
        return int(self._health['readers'])

    def wait_heard(self) -> None:
        """Wait until it serves, and has heard of the node."""
        self.wait_ready()
        deadline = time.monotonic() + PATIENCE_S
        while not self._health['heard']:
            assert time.monotonic() < deadline, 'the page has heard nothing of the node'
            time.sleep(_LOOK_S)

    @property
    def _health(self) -> Any:
        with urlopen(f'http://127.0.0.1:{self.port}/healthz', timeout=PATIENCE_S) as answer:
            return json.load(answer)


class Browser:
    """Somebody at the page."""

    def __init__(self, port: int, name: str) -> None:
        self._at = f'127.0.0.1:{port}'
        self._http = http.client.HTTPConnection(self._at, timeout=PATIENCE_S)
        self._cookie = ''
        login = self.post('/api/login', {'name': name, 'password': PASSWORD})
        assert login['role'] == name, login

    def post(self, path: str, body: Mapping[str, Any]) -> Any:
        """Send something; returns what is answered."""
        headers = {
            'Content-Type': 'application/json',
            'Origin': f'http://{self._at}',
            'Cookie': self._cookie,
        }
        self._http.request('POST', path, json.dumps(body), headers)
        answer = self._http.getresponse()
        self._cookie = (answer.getheader('Set-Cookie') or self._cookie).partition(';')[0]
        return json.loads(answer.read())

    def ask(self, name: str, **given: Any) -> Any:
        """Make a request."""
        return self.post(f'/api/requests/{name}', {'reason': 'a test', **given})

    def close(self) -> None:
        """Leave."""
        self._http.close()
