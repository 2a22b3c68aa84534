"""Faults of a PostgreSQL server, and waits for them, for tests."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager

import psycopg

from bt_orchestrator.extensions.postgres.connecting import Connection

IN_TIME_S = 30.0


@contextmanager
def without_replica(person: Connection) -> Iterator[None]:
    """Let commits wait for a replica that is not there."""
    _set(person, "'nobody'")
    person.execute('SET synchronous_commit = local')
    wait_for(lambda: _a_commit_waits(person))
    try:
        yield
    finally:
        _set(person, "''")


def _set(person: Connection, names: str) -> None:
    person.execute(f'ALTER SYSTEM SET synchronous_standby_names = {names}'.encode())
    person.execute('SELECT pg_reload_conf()')
    wait_for(
        lambda: person.execute('SHOW synchronous_standby_names').fetchone() == (names.strip("'"),)
    )


def _a_commit_waits(person: Connection) -> bool:
    """Try it: the server lets commits wait some time after sessions show its new setting."""
    with closing(psycopg.connect(person.info.dsn, autocommit=True)) as other:
        other.pgconn.send_query(b"SELECT pg_logical_emit_message(true, 'a test', '')")
        wait_for(lambda: _is_answered(other) or waiting(person))
        waits = not _is_answered(other)
        person.execute('SELECT pg_terminate_backend(%s, 30000)', (other.info.backend_pid,))
    return waits


def _is_answered(other: Connection) -> bool:
    other.pgconn.consume_input()
    return not other.pgconn.is_busy()


def waiting(person: Connection) -> bool:
    query = "SELECT count(*) FROM pg_stat_activity WHERE wait_event = 'SyncRep'"
    return bool(person.execute(query).fetchone() != (0,))


def cancel(person: Connection) -> None:
    wait_for(lambda: waiting(person))
    person.execute(
        "SELECT pg_cancel_backend(pid) FROM pg_stat_activity WHERE wait_event = 'SyncRep'"
    )


def wait_for(is_there: Callable[[], bool]) -> None:
    until = time.monotonic() + IN_TIME_S
    while not is_there():
        assert time.monotonic() < until
        time.sleep(0.01)


def in_thread(work: Callable[[], object]) -> Callable[[], None]:
    """Begin some work, and return what waits for its end."""
    raised: list[BaseException] = []

    def run() -> None:
        try:
            work()
        except BaseException as error:  # noqa: BLE001 - raised again
            raised.append(error)

    thread = threading.Thread(target=run, daemon=True)
    thread.start()

    def ended() -> None:
        thread.join(IN_TIME_S)
        assert not thread.is_alive()
        if raised:
            raise raised[0]

    return ended
