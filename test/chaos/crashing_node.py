"""The tree node with a crash point: it kills itself at the nth pass of one step of a settle.

    python test/chaos/crashing_node.py POINT NTH FILE run --cell CELL ...

It dies as by kill -9. Before, it appends to FILE, as one line of JSON, at which point it dies and
how many goals run.
"""

from __future__ import annotations

import json
import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from bt_orchestrator.cli.main import main
from bt_orchestrator.ros.gateway import RosGateway
from bt_orchestrator.ros.outputs import EventsTopic
from bt_orchestrator.runtime.flights import Flights
from bt_orchestrator.runtime.orchestrator import Orchestrator
from bt_orchestrator.store.sqlite import SqliteStore

POINTS = {
    'landed': 'ends of goals are events in memory',
    'ticked': 'the tree has decided, nothing is written',
    'writing': 'the transaction is open and full',
    'committed': 'it is durable, nothing is sent',
    'sent': 'a goal was handed to the middleware',
    'told': 'the events were published',
}


class CrashPoint:
    """Counts the passes of its point; the last one does not return."""

    def __init__(self, point: str, nth: int, file: Path) -> None:
        self._point = point
        self._left = nth
        self._file = file
        self._running: Callable[[], int] = lambda: 0

    def arm(self) -> None:
        """Put itself behind, or before, the step."""
        _after(Orchestrator, '__init__', self._note)
        _ARM[self._point](self)

    def after(self, kind: type, method: str) -> None:
        """Be passed after each call of a method."""
        original = getattr(kind, method)

        def called(*args: Any, **options: Any) -> Any:
            answer = original(*args, **options)
            self.passed()
            return answer

        setattr(kind, method, called)

    def before_each_commit(self) -> None:
        """Be passed before SQLite carries out a COMMIT of events."""
        _after(
            SqliteStore,
            '_be_writable',
            lambda store: store._database.set_trace_callback(self._read_statement),
        )

    def _note(self, engine: Orchestrator) -> None:
        self._running = lambda: len(engine.state.running)

    def _read_statement(self, statement: str) -> None:
        if statement == 'COMMIT':
            self.passed()

    def passed(self) -> None:
        """Die at the nth time."""
        self._left -= 1
        if self._left:
            return
        with self._file.open('a') as file:
            file.write(json.dumps({'point': self._point, 'running': self._running()}) + '\n')
        os.kill(os.getpid(), signal.SIGKILL)


def _after(kind: type, method: str, then: Callable[[Any], None]) -> None:
    """Do something with an object after each call of its method."""
    original = getattr(kind, method)

    def called(made: Any, *args: Any, **options: Any) -> None:
        original(made, *args, **options)
        then(made)

    setattr(kind, method, called)


_ARM: dict[str, Callable[[CrashPoint], None]] = {
    'landed': lambda point: point.after(Flights, 'land'),
    'ticked': lambda point: point.after(Orchestrator, '_tick_until_still'),
    'writing': lambda point: point.before_each_commit(),
    'committed': lambda point: point.after(SqliteStore, 'append'),
    'sent': lambda point: point.after(RosGateway, 'send'),
    'told': lambda point: point.after(EventsTopic, 'publish'),
}

if __name__ == '__main__':
    CrashPoint(sys.argv[1], int(sys.argv[2]), Path(sys.argv[3])).arm()
    sys.exit(main(sys.argv[4:]))
