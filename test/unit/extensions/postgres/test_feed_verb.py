"""The verb `feed`: what it prints, and what it refuses."""

from __future__ import annotations

import json
import re
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from fakes.long_journal import LongRun
from patience import PATIENCE_S
from postgres_server import PostgresServer, postgres_server
from program_process import ProgramProcess

from bt_orchestrator.cli.main import main


@pytest.fixture
def journal(tmp_path: Path) -> Path:
    run = LongRun(tmp_path / 'journal.sqlite3')
    run.job('J1', 1)
    run.close()
    return tmp_path / 'journal.sqlite3'


@pytest.fixture
def database(server: PostgresServer) -> str:
    return server.database()


def feed(server: PostgresServer, database: str, *words: str, cell: str = '') -> int:
    to = server.place(database, cell) if cell else server.address(database)
    return main(['feed', '--to', to, *words])


def test_journal_is_copied_under_its_cell_name(
    server: PostgresServer, database: str, journal: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ('--journal', str(journal), '--page', 'http://line-1:8080/')
    assert feed(server, database, *words) == 0
    assert capsys.readouterr().out == (
        f'postgresql://plant@/{database}/test_line: 38 events copied, up to event 38\n'
    )
    assert feed(server, database, *words) == 0
    assert '0 events copied, up to event 38' in capsys.readouterr().out
    assert feed(server, database, '--list') == 0
    text = capsys.readouterr().out
    assert re.fullmatch(r'test_line  Complete  up to event 38, complete \d s ago\n', text), text


def test_gap_is_reported_and_sets_exit_status(
    server: PostgresServer, database: str, journal: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    import sqlite3
    from contextlib import closing

    with closing(sqlite3.connect(journal, isolation_level=None)) as file:
        file.execute('DELETE FROM events WHERE seq BETWEEN 5 AND 6')
    assert feed(server, database, '--journal', str(journal), cell='line 1') == 1
    assert 'line 1: events 5 to 6 were damaged in the journal' in capsys.readouterr().err


@pytest.mark.parametrize(
    ('words', 'message', 'status'),
    [
        (('--to', 'nonsense'), "expected the address of a plant's database", 1),
        (('--to', 'postgresql:///plant?host=/nowhere'), 'cannot be reached', 1),
        ((), 'the following arguments are required: --to', 2),
        (('--to', 'postgresql://a:b@h/p'), 'expected an address without a password', 2),
    ],
)
def test_what_is_refused(
    journal: Path,
    capsys: pytest.CaptureFixture[str],
    words: tuple[str, ...],
    message: str,
    status: int,
) -> None:
    try:
        exit_code = main(['feed', '--journal', str(journal), *words])
    except SystemExit as end:
        exit_code = int(str(end.code))
    assert (exit_code, message in capsys.readouterr().err) == (status, True)


def test_missing_package_error_says_how_to_install(
    journal: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, 'psycopg', None)
    assert main(['feed', '--journal', str(journal), '--to', 'postgresql:///plant']) == 2
    errors = capsys.readouterr().err
    assert "pip install 'psycopg[binary]>=3.1'" in errors
    assert 'psycopg cannot be imported' in errors


def test_a_journal_that_is_not_there(
    server: PostgresServer, database: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert feed(server, database, '--journal', str(tmp_path / 'none')) == 1
    assert 'there is no journal' in capsys.readouterr().err


def until(process: ProgramProcess, is_so: Callable[[], object]) -> None:
    deadline = time.monotonic() + PATIENCE_S
    while not is_so():
        assert process.is_running, process.errors
        assert time.monotonic() < deadline, process.errors
        time.sleep(0.02)


def test_follower_survives_database_outage(journal: Path, tmp_path: Path) -> None:
    with postgres_server() as server:
        database = server.database()
        assert feed(server, database, '--journal', str(journal), cell='line_1') == 0
        words = ['events', '--journal', server.place(database, 'line_1'), '--follow']
        follower = ProgramProcess(words, tmp_path, 'follower')
        follower.wait_ready('job.completed')
        server.stop(signal.SIGQUIT)
        until(follower, lambda: 'goes on when the database is back' in follower.errors)
        server.start()
        run = LongRun(journal)
        run.job('J2', 1)
        run.close()
        assert feed(server, database, '--journal', str(journal), cell='line_1') == 0
        until(follower, lambda: re.search('"job.completed".*"J2"', follower.output))
        follower.send(signal.SIGINT)
        assert follower.wait() == 0
    numbers = [json.loads(line)['seq'] for line in follower.output.splitlines()]
    assert numbers == list(range(1, len(numbers) + 1))
    assert follower.errors.count('goes on when') == 1
