"""Rows of a journal in PostgreSQL, in turns with a file on the same disk."""

from __future__ import annotations

import statistics
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path
from typing import Any

from contract.written_events import events
from postgres_server import PostgresServer

from bench.ros_rows import REST_S
from bench.rows import Row, percentile
from bench.stand import Measured, stand
from bt_orchestrator.ros.node_parameters import SINGLE
from bt_orchestrator.store.sqlite.store import SqliteStore

DISK = '/var/tmp'
DURABLE = {'fsync': 'on', 'shared_buffers': '128MB'}

EVENTS_A_SETTLE = 4

FILE, DATABASE, REPLICATED = 'file FULL', 'PostgreSQL', 'PostgreSQL, a synchronous replica'


def append(rounds: int, appends: int) -> Iterator[Row]:
    """Compare a cold append of a few events with that of a file."""
    times: list[dict[str, float]] = []
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix='bench_', dir=DISK)))
        plain = stack.enter_context(server())
        replicated = stack.enter_context(server(replica=True))
        for number in range(rounds):
            makes: dict[str, Callable[[], Any]] = {
                FILE: lambda number=number: SqliteStore(folder / f'{number}.sqlite3'),  # type: ignore[misc]
                DATABASE: lambda: in_database(plain, folder),
                REPLICATED: lambda: in_database(replicated, folder),
            }
            names = list(makes) if number % 2 else list(makes)[::-1]
            times.append({name: _append_s(makes[name], appends) for name in names})
    notes: dict[str, object] = {
        f'{name}, p50, ms': statistics.median(r[name] for r in times) * 1e3 for name in times[0]
    }
    replicas = [r[REPLICATED] / r[FILE] for r in times]
    notes['with a synchronous replica / file'] = statistics.median(replicas)
    yield Row('postgres_append', [r[DATABASE] / r[FILE] for r in times], notes)


def dispatch(rounds: int, cycles: int) -> Iterator[Row]:
    """Compare the time between two tasks of a section with that of a journal in a file."""
    times: list[dict[str, float]] = []
    with stand() as here, server() as database:
        drives: dict[str, Callable[[], Measured]] = {
            FILE: lambda: here.ours(cycles, 'FULL', SINGLE),
            DATABASE: lambda: here.ours(cycles, 'FULL', SINGLE, journal=place(database)),
        }
        for number in range(rounds):
            names = list(drives) if number % 2 else list(drives)[::-1]
            times.append({name: percentile(drives[name]().sequence, 0.5) for name in names})
    notes = {
        f'{name}, p50, ms': statistics.median(r[name] for r in times) * 1e3 for name in drives
    }
    yield Row('postgres_dispatch', [r[DATABASE] / r[FILE] for r in times], notes)


@contextmanager
def server(*, replica: bool = False) -> Iterator[PostgresServer]:
    """Give a server that keeps what it confirms.

    :param replica: each commit waits for one
    """
    with ExitStack() as stack:
        made = stack.enter_context(closing(PostgresServer(None, DISK, **DURABLE)))
        made.start()
        if replica:
            follower = stack.enter_context(closing(PostgresServer(made, DISK, **DURABLE)))
            follower.start()
            made.wait_for_replicas('*')
        yield made


def place(of: PostgresServer) -> str:
    """Return the address of a new journal."""
    return of.place(of.database(), 'bench_cell')


def in_database(of: PostgresServer, folder: Path) -> Any:
    from bt_orchestrator.extensions.postgres.journal import PostgresStore

    return PostgresStore(place(of), folder)


def _append_s(make: Callable[[], Any], appends: int) -> float:
    """Return the median time of an append after a rest, as between two tasks."""
    times = []
    with closing(make()) as store:
        for first in range(1, appends * EVENTS_A_SETTLE, EVENTS_A_SETTLE):
            batch = events(first, first + EVENTS_A_SETTLE - 1)
            time.sleep(REST_S)
            began = time.perf_counter()
            store.append(batch)
            times.append(time.perf_counter() - began)
    return statistics.median(times)
