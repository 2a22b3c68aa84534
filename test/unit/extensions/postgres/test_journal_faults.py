"""Faults of server and network while a journal is written: no event is lost, or written twice."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from contract.written_events import events
from postgres_faults import IN_TIME_S, cancel, in_thread, wait_for, waiting, without_replica
from postgres_proxy import through
from postgres_server import PostgresServer, postgres_server

from bt_orchestrator.base.errors import JournalFailed, JournalUnusable
from bt_orchestrator.extensions.postgres.connecting import Connection, connected, place_of
from bt_orchestrator.extensions.postgres.journal import (
    PATIENCE_S,
    RUNNING_S,
    PostgresStore,
)
from bt_orchestrator.ports import Snapshot


@pytest.fixture(scope='module')
def own() -> Iterator[PostgresServer]:
    """Give a server that a test may stop."""
    with postgres_server() as instance:
        yield instance


@pytest.fixture
def address(own: PostgresServer) -> str:
    return own.place(own.database(), 'line_1')


@pytest.fixture
def person(own: PostgresServer, address: str) -> Iterator[Connection]:
    """Give the connection of somebody who looks on."""
    with connected(place_of(address), 'test', ['SET search_path = cell_1']) as session:
        yield session


def test_9_1_event_with_lost_answer_is_written_once(
    address: str, own: PostgresServer, tmp_path: Path
) -> None:
    with (
        through(address, own.folder) as (place, proxy),
        closing(PostgresStore(place, tmp_path)) as store,
    ):
        for first in range(1, 41, 2):
            proxy.loses_answer.set()
            store.append(events(first, first + 1))
            assert not proxy.loses_answer.is_set()
        assert list(store.read()) == events(1, 40)


def test_9_1_an_answer_before_the_commit_is_no_commit(
    address: str, own: PostgresServer, tmp_path: Path
) -> None:
    with (
        through(address, own.folder) as (place, proxy),
        closing(PostgresStore(place, tmp_path)) as store,
    ):
        for first in range(1, 41, 2):
            proxy.loses_commit.set()
            store.append(events(first, first + 1))
            assert not proxy.loses_commit.is_set()
        assert list(store.read()) == events(1, 40)


def test_9_1_history_end_with_lost_answer_is_written_once(
    address: str, own: PostgresServer, tmp_path: Path
) -> None:
    with through(address, own.folder) as (place, proxy):
        with closing(PostgresStore(place, tmp_path)) as store:
            store.append(events(1, 20))
        with closing(PostgresStore(place, tmp_path)) as store:
            store.go_on_after(12)
            proxy.loses_answer.set()
            store.append(events(13, 14))
            assert proxy.happened.is_set()
            history = store.history
        with closing(PostgresStore(place, tmp_path)) as store:
            assert (store.history, list(store.read())) == (history, events(1, 14))


def test_the_server_plans_appends_once_a_connection(address: str, tmp_path: Path) -> None:
    with closing(PostgresStore(address, tmp_path)) as store:
        for first in range(1, 21, 2):
            store.append(events(first, first + 1))
        with store.writing() as session:
            plans = session.ask(
                'SELECT generic_plans, custom_plans FROM pg_prepared_statements'
            ).fetchall()
    assert plans == [(10, 0)]


def test_9_1_a_cancelled_wait_for_replicas_is_no_commit(
    address: str, person: Connection, tmp_path: Path
) -> None:
    with closing(PostgresStore(address, tmp_path)) as store:
        store.patience_s = IN_TIME_S
        store.append(events(1, 2))
        with without_replica(person):
            failed = in_thread(lambda: store.append(events(3, 4)))
            cancel(person)
            with pytest.raises(JournalFailed, match='canceling wait for synchronous replication'):
                failed()


def test_9_1_visible_rows_without_replica_do_not_confirm_write(
    address: str, own: PostgresServer, person: Connection, tmp_path: Path
) -> None:
    """A crash of the server shows them, and no replica has them."""
    with closing(PostgresStore(address, tmp_path)) as store:
        store.append(events(1, 2))
        with without_replica(person):
            failed = in_thread(lambda: store.append(events(3, 4)))
            wait_for(lambda: waiting(person))
            person.execute(
                'SELECT pg_terminate_backend(pid) FROM pg_stat_activity '
                "WHERE wait_event = 'SyncRep'"
            )
            wait_for(lambda: person.execute('SELECT max(seq) FROM events').fetchone() == (4,))
            with pytest.raises(JournalFailed):
                failed()


def test_9_1_start_waits_until_replicas_have_the_journal(
    address: str, own: PostgresServer, person: Connection, tmp_path: Path
) -> None:
    PostgresStore(address, tmp_path).close()
    with without_replica(person):
        opened = in_thread(lambda: PostgresStore(address, tmp_path).close())
        wait_for(lambda: waiting(person))
    opened()


def test_9_1_events_missing_on_promoted_replica_leave_no_gap(
    address: str, person: Connection, tmp_path: Path
) -> None:
    with closing(PostgresStore(address, tmp_path)) as store:
        store.append(events(1, 20))
        person.execute('DELETE FROM events WHERE seq > 15')
        person.execute(
            'SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE pid <> pg_backend_pid() '
            "AND application_name = 'bt_orchestrator node'"
        )
        with pytest.raises(JournalFailed, match='the last event is 15 and not 20'):
            store.append(events(21, 22))
    assert person.execute('SELECT max(seq) FROM events').fetchone() == (15,)
    with closing(PostgresStore(address, tmp_path)) as store:
        assert '5 events are missing: event 20 of' in store.missing(15)


def test_9_1_who_has_lost_the_cell_writes_nothing(
    address: str, person: Connection, tmp_path: Path
) -> None:
    with closing(PostgresStore(address, tmp_path)) as store:
        store.append(events(1, 2))
        person.execute('UPDATE plant.cells SET epoch = epoch + 1')
        with pytest.raises(JournalFailed, match='another orchestrator has taken over'):
            store.append(events(3, 4))
        with pytest.raises(JournalFailed, match='another orchestrator has taken over'):
            store.begin_with(Snapshot(2, 'program', '{}'))
    assert person.execute('SELECT max(seq) FROM events').fetchone() == (2,)


@pytest.mark.parametrize('how', [signal.SIGINT, signal.SIGQUIT], ids=['stop', 'crash'])
def test_9_1_server_back_in_time_is_no_failure(
    address: str, own: PostgresServer, tmp_path: Path, how: int
) -> None:
    with closing(PostgresStore(address, tmp_path)) as store:
        store.append(events(1, 2))
        own.stop(how)
        appended = in_thread(lambda: store.append(events(3, 4)))
        own.start()
        appended()
        store.append(events(5, 6))
        assert list(store.read()) == events(1, 6)


def test_9_1_absent_server_fails_append_and_loses_nothing(
    address: str, own: PostgresServer, tmp_path: Path
) -> None:
    with closing(PostgresStore(address, tmp_path)) as store:
        store.append(events(1, 2))
        own.stop()
        try:
            began = time.monotonic()
            with pytest.raises(JournalFailed, match='cannot be written'):
                store.append(events(3, 4))
            assert PATIENCE_S - 1 < time.monotonic() - began < PATIENCE_S + 3
            with pytest.raises(JournalUnusable):
                list(store.read())
            with pytest.raises(JournalUnusable, match='cannot be reached'):
                PostgresStore(address, tmp_path)
        finally:
            own.start()
    with closing(PostgresStore(address, tmp_path)) as store:
        assert list(store.read()) == events(1, 2)


def test_9_1_hanging_server_delays_readers_only_briefly(
    address: str, own: PostgresServer, person: Connection, tmp_path: Path
) -> None:
    with closing(PostgresStore(address, tmp_path)) as store:
        store.append(events(1, 2))
        backends = person.execute(
            "SELECT pid FROM pg_stat_activity WHERE application_name = 'bt_orchestrator node'"
        ).fetchall()
        for (pid,) in backends:
            os.kill(pid, signal.SIGSTOP)
        try:
            began = time.monotonic()
            for _ in range(3):
                with pytest.raises(JournalUnusable):
                    store.first_seq()
            assert time.monotonic() - began < RUNNING_S + 1
        finally:
            for (pid,) in backends:
                os.kill(pid, signal.SIGCONT)
        store.append(events(3, 4))
        assert list(store.read()) == events(1, 4)
