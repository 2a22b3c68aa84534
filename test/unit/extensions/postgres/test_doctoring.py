"""What `doctor` says of a database that is to keep a journal."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from socket import gethostname

import pytest
from postgres_faults import wait_for
from postgres_server import USER, PostgresServer, postgres_server, program

from bt_orchestrator.base.diagnosis.check import Verdict
from bt_orchestrator.extensions.postgres.connecting import connected, place_of
from bt_orchestrator.extensions.postgres.doctoring import CELL, COPIES, DATABASE, WRITES, checks
from bt_orchestrator.extensions.postgres.journal import PostgresStore
from bt_orchestrator.extensions.postgres.schema import FEED, enter


def verdicts(address: str) -> dict[str, tuple[Verdict, str]]:
    return {check.name: (check.verdict, check.found) for check in checks(address)}


@pytest.fixture
def waiting() -> Iterator[PostgresServer]:
    """Give a server whose commits wait for a replica that is not there."""
    with postgres_server(synchronous_standby_names='far') as instance:
        yield instance


def test_a_server_without_a_replica_is_warned_of(server: PostgresServer) -> None:
    results = verdicts(server.place(server.database(), 'line_1'))
    assert results.pop(COPIES)[0] is Verdict.WARN
    assert {verdict for verdict, _ in results.values()} == {Verdict.OK}
    assert 'has no journal there yet' in results[CELL][1]


def test_the_journal_of_the_cell_is_named(server: PostgresServer, tmp_path: Path) -> None:
    address = server.place(server.database(), 'line_1')
    with closing(PostgresStore(address, tmp_path)) as store:
        assert store.history in verdicts(address)[CELL][1]


def test_the_leader_of_the_cell_is_named(server: PostgresServer, tmp_path: Path) -> None:
    address = server.place(server.database(), 'line_1')
    leader = f'{gethostname()}, process {os.getpid()}, epoch 1'
    with closing(PostgresStore(address, tmp_path)):
        assert f'led by {leader}' in verdicts(address)[CELL][1]
    assert f'led by no node now, last by {leader}' in verdicts(address)[CELL][1]


def test_a_replica_that_no_commit_waits_for_fails(server: PostgresServer, tmp_path: Path) -> None:
    address = server.place(server.database(), 'line_1')
    words = [program('pg_receivewal'), '--host', str(server.folder), '--username', USER]
    with subprocess.Popen([*words, '--directory', str(tmp_path)]) as replica:
        try:
            wait_for(lambda: verdicts(address)[COPIES][0] is Verdict.FAIL)
            assert 'a promotion loses events' in verdicts(address)[COPIES][1]
        finally:
            replica.terminate()


def test_running_backup_does_not_count_as_replica(server: PostgresServer) -> None:
    address = server.place(server.database(), 'line_1')
    words = [program('pg_basebackup'), '--host', str(server.folder), '--username', USER]
    slowly = ['--max-rate', '32k', '--checkpoint', 'fast', '--wal-method', 'none']
    to = ['--format', 'tar', '--pgdata', '-']
    with subprocess.Popen([*words, *slowly, *to], stdout=subprocess.DEVNULL) as backup:
        try:
            server.until("SELECT count(*) = 1 FROM pg_stat_replication WHERE state = 'backup'")
            assert verdicts(address)[COPIES][0] is Verdict.WARN
            assert 'no commit waits for a replica' in verdicts(address)[COPIES][1]
        finally:
            backup.terminate()


def test_a_copy_is_no_journal(server: PostgresServer) -> None:
    address = server.place(server.database(), 'line_1')
    with connected(place_of(address), 'test') as connection:
        enter(connection, 'line_1', FEED, 'a feed')
    assert verdicts(address)[CELL][0] is Verdict.FAIL


def test_a_replica_that_is_away_fails(waiting: PostgresServer) -> None:
    verdict, words = verdicts(waiting.place('postgres', 'line_1'))[COPIES]
    assert verdict is Verdict.FAIL
    assert 'wait for far' in words


def test_asynchronous_replicas_fail_alone_and_warn_beside_synchronous() -> None:
    with postgres_server() as main, closing(main.replica()), closing(main.replica()):
        address = main.place(main.database(), 'line_1')
        main.until("SELECT count(*) = 2 FROM pg_stat_replication WHERE state = 'streaming'")
        verdict, words = verdicts(address)[COPIES]
        assert (verdict, words[:10]) == (Verdict.FAIL, '2 replicas')
        main.wait_for_replicas('*')
        main.until("SELECT count(*) = 1 FROM pg_stat_replication WHERE sync_state = 'sync'")
        verdict, words = verdicts(address)[COPIES]
        assert verdict is Verdict.WARN
        assert 'and not for 1 others' in words
        main.ask('CREATE ROLE poor LOGIN')
        verdict, words = verdicts(address.replace('//plant@', '//poor@'))[COPIES]
        assert verdict is Verdict.WARN
        assert 'this role may not see' in words
        main.ask('GRANT pg_read_all_stats TO poor')
        assert 'and not for 1' in verdicts(address.replace('//plant@', '//poor@'))[COPIES][1]
        main.wait_for_replicas('')


def test_a_role_without_rights_fails(server: PostgresServer) -> None:
    database = server.database()
    with connected(place_of(server.address(database)), 'test') as connection:
        connection.execute(b'CREATE ROLE poor LOGIN')
    address = server.place(database, 'line_1').replace('//plant@', '//poor@')
    assert verdicts(address)[WRITES][0] is Verdict.FAIL


def test_a_server_that_is_not_there_fails(tmp_path: Path) -> None:
    results = verdicts(f'postgresql://plant@/plant/line_1?host={tmp_path}')
    assert list(results) == [DATABASE]
    assert results[DATABASE][0] is Verdict.FAIL


def test_an_address_without_a_cell_fails(server: PostgresServer) -> None:
    assert verdicts(server.address('postgres'))[CELL][0] is Verdict.FAIL
