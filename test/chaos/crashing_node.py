"""The tree node on a computer whose clock is wrong, and with a crash point, if wanted.

    python test/chaos/crashing_node.py FOLDER AHEAD_S [POINT NTH kill|stop]... run --cell CELL ...

Its clock is AHEAD_S seconds ahead of the real one; what the machine counts since it was started is
as it is. To FOLDER/clocks.jsonl it appends from which event on that is so, as one line of JSON.

At the nth pass of a step of a settle it dies as by kill -9, or stops until it is continued. Each
such point counts from when FOLDER/armed_0 is there, or armed_1 for the second. Before, it appends
to FOLDER/crashes.jsonl at which point that is and how many goals run.
"""

from __future__ import annotations

import json
import os
import signal
import sys
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from bt_orchestrator.cli.main import main
from bt_orchestrator.engine.runtime.flights import Flights
from bt_orchestrator.engine.runtime.ledger import Ledger
from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.ros import clock
from bt_orchestrator.ros.actions.gateway import RosGateway
from bt_orchestrator.ros.clock import RosClock
from bt_orchestrator.ros.services.outputs import EventsTopic
from bt_orchestrator.store.sqlite.store import SqliteStore

CRASHES = 'crashes.jsonl'
CLOCKS = 'clocks.jsonl'

BOOT = 'boot'
"""A file with the id of the boot of the machine, where it is to be another one than it is."""

POINTS = {
    'landed': 'ends of goals are events in memory',
    'ticked': 'the tree has decided, nothing is written',
    'writing': 'the transaction is open and has the first event',
    'committed': 'it is durable, nothing is sent',
    'sent': 'a goal was handed to the middleware',
    'told': 'the events were published',
}


KILL, STOP = 'kill', 'stop'

_SIGNALS = {KILL: signal.SIGKILL, STOP: signal.SIGSTOP}


def armed(place: int) -> str:
    """Return the name of the file without which a crash point does nothing."""
    return f'armed_{place}'


class CrashPoint:
    """Counts the passes of its point while it may; the last one does not return, or late."""

    def __init__(self, point: str, nth: int, how: str, folder: Path, place: int) -> None:
        self._point = point
        self._left = nth
        self._signal = _SIGNALS[how]
        self._may = folder / armed(place)
        self._file = folder / CRASHES
        self._running: Callable[[], int] = lambda: 0
        self._commits_in_database = False
        self._is_first = True
        """The next event that is inserted is the first of its transaction."""

    def arm(self) -> None:
        """Put itself behind, or before, the step."""
        _after(Orchestrator, '__init__', self._note)
        _ARM[self._point](self)

    def after(self, kind: type, method: str) -> None:
        """Be passed after each call of a method."""
        _after(kind, method, lambda _: self.passed())

    def after_each_commit(self) -> None:
        """Be passed when the events are durable."""
        for store in (SqliteStore, *(store for store, _ in _databases())):
            self.after(store, 'append')

    def within_each_commit(self) -> None:
        """Be passed when SQLite has the first event of several, or the only one, in hand."""
        _after(SqliteStore, '_begin_to_write', self._set_trigger)
        _after(SqliteStore, 'append', self._note_commit)
        for store, session in _databases():
            _before(store, '_insert', self._note_insert)
            _before(session, '_wait', self._await_answer)

    def _note(self, engine: Orchestrator) -> None:
        self._running = lambda: len(engine.state.running)

    def _set_trigger(self, store: SqliteStore) -> None:
        store._database.create_function('inserted', 0, self._inserted)
        store._database.execute(
            'CREATE TEMP TRIGGER crash AFTER INSERT ON events BEGIN SELECT inserted(); END'
        )

    def _note_insert(self, _: object) -> None:
        self._commits_in_database = True

    def _await_answer(self, _: object) -> None:
        """Be passed when the server has the statement, whatever it makes of it."""
        if self._commits_in_database:
            self._commits_in_database = False
            self.passed()

    def _inserted(self) -> None:
        is_first, self._is_first = self._is_first, False
        if is_first:
            self.passed()

    def _note_commit(self, _: object) -> None:
        self._is_first = True

    def passed(self) -> None:
        """Die or stop at the nth time."""
        if self.is_over or not self._may.exists():
            return
        self._left -= 1
        if self._left:
            return
        _append(self._file, point=self._point, running=self._running())
        os.kill(os.getpid(), self._signal)

    @property
    def is_over(self) -> bool:
        """Tell whether it was passed often enough."""
        return self._left <= 0


def _databases() -> Iterator[tuple[type, type]]:
    """Yield the store in a database, and its session, if it is installed."""
    if find_spec('psycopg') is not None:
        from bt_orchestrator.extensions.postgres.journal import PostgresStore
        from bt_orchestrator.extensions.postgres.session import Session

        yield PostgresStore, Session


def set_machine(folder: Path) -> None:
    """Be on another machine, if there is the file that names its boot."""
    if (folder / BOOT).exists():
        boot = (folder / BOOT).read_text()

        def boot_id(proc: Path) -> str | None:
            return boot

        clock._boot_id = boot_id


def set_clock(ahead_s: float, folder: Path) -> None:
    """Set the wall clock of the node, and say from which event on it is so."""
    original = RosClock.now
    RosClock.now = lambda self: original(self) + ahead_s  # type: ignore[method-assign]

    def note(ledger: Ledger) -> None:
        _append(folder / CLOCKS, after_seq=ledger.state.seq, ahead_s=ahead_s)

    _after(Ledger, '__init__', note)


def _append(path: Path, **record: Any) -> None:
    with path.open('a') as file:
        file.write(json.dumps(record) + '\n')


def _before(kind: type, method: str, then: Callable[[Any], None]) -> None:
    """Do something with an object before each call of its method."""
    original = getattr(kind, method)

    def called(made: Any, *args: Any, **options: Any) -> Any:
        then(made)
        return original(made, *args, **options)

    setattr(kind, method, called)


def _after(kind: type, method: str, then: Callable[[Any], None]) -> None:
    """Do something with an object after each call of its method."""
    original = getattr(kind, method)

    def called(made: Any, *args: Any, **options: Any) -> Any:
        answer = original(made, *args, **options)
        then(made)
        return answer

    setattr(kind, method, called)


_ARM: dict[str, Callable[[CrashPoint], None]] = {
    'landed': lambda point: point.after(Flights, 'land'),
    'ticked': lambda point: point.after(Orchestrator, '_tick_until_still'),
    'writing': lambda point: point.within_each_commit(),
    'committed': lambda point: point.after_each_commit(),
    'sent': lambda point: point.after(RosGateway, 'send'),
    'told': lambda point: point.after(EventsTopic, 'publish'),
}

if __name__ == '__main__':
    _folder, _ahead_s, *_words = sys.argv[1:]
    set_machine(Path(_folder))
    set_clock(float(_ahead_s), Path(_folder))
    _place = 0
    while _words[0] in POINTS:
        _name, _nth, _how, *_words = _words
        CrashPoint(_name, int(_nth), _how, Path(_folder), _place).arm()
        _place += 1
    sys.exit(main(_words))
