"""A journal of an older program becomes one of today, and keeps what it says."""

from __future__ import annotations

import re
import shutil
import sqlite3
from pathlib import Path

import pytest
from fakes.line import Line
from fakes.long_journal import LongRun

from bt_orchestrator.base.errors import JournalUnusable
from bt_orchestrator.engine.runtime.recovery import restore
from bt_orchestrator.model.events import JobStarted, OrchestratorStarted
from bt_orchestrator.store.memory import MemoryStore
from bt_orchestrator.store.sqlite import schema
from bt_orchestrator.store.sqlite.schema import SCHEMA
from bt_orchestrator.store.sqlite.store import SqliteStore

SCHEMA_1 = Path(__file__).parents[3] / 'data' / 'journal_schema_1.sqlite3'
"""Two jobs that ended, written by the program that knew schema 1."""


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return Path(shutil.copy(SCHEMA_1, tmp_path / 'journal.sqlite3'))


def contents(path: Path) -> tuple[int, list[tuple[int, str]], set[str]]:
    database = sqlite3.connect(path)
    version = database.execute('PRAGMA user_version').fetchone()[0]
    rows = database.execute('SELECT seq, record FROM events ORDER BY seq').fetchall()
    tables = {name for (name,) in database.execute('SELECT name FROM sqlite_schema')}
    database.close()
    return version, rows, tables


def test_schema_1_upgrade_keeps_every_event(path: Path) -> None:
    version, rows, tables = contents(path)
    assert (version, len(rows), tables) == (1, 156, {'events'})
    SqliteStore(path).close()
    assert contents(path)[:2] == (SCHEMA, rows)
    assert contents(path)[2] > {
        'events',
        'snapshots',
        'beginning',
        'jobs',
        'queued',
        'history',
    }


def test_cell_resumes_where_older_program_stopped(path: Path) -> None:
    store = SqliteStore(path)
    state = restore(Line(faults={'a2': '#2=abort'}).cell, store)
    assert {name: job.progress.packed for name, job in state.ended.items()} == {'J1': 3, 'J2': 2}
    store.append([JobStarted(seq=157, job='J3')])
    assert store.first_needed([], keep_jobs=1) == 94
    store.close()


def test_a_step_that_fails_leaves_the_older_file(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = contents(path)
    broken = (*schema._STEPS[1], 'CREATE TABLE events (again INTEGER)')
    monkeypatch.setattr(schema, '_STEPS', (schema._STEPS[0], broken))
    with pytest.raises(JournalUnusable, match='table events already exists'):
        SqliteStore(path)
    assert contents(path) == before


def test_new_file_has_same_tables_as_old(path: Path, tmp_path: Path) -> None:
    SqliteStore(path).close()
    SqliteStore(tmp_path / 'new.sqlite3').close()
    assert contents(tmp_path / 'new.sqlite3')[2] == contents(path)[2]


def history(path: Path) -> str:
    store = SqliteStore(path)
    try:
        return store.history
    finally:
        store.close()


def test_every_journal_keeps_a_unique_name(path: Path, tmp_path: Path) -> None:
    others = [path, tmp_path / 'new.sqlite3', tmp_path / 'newer.sqlite3']
    names = [history(journal) for journal in others]
    assert all(re.fullmatch('[0-9a-f]{32}', name) for name in names)
    assert len({*names, MemoryStore().history, MemoryStore().history}) == 5
    assert [history(journal) for journal in others] == names


def test_a_journal_without_its_name_is_refused(path: Path) -> None:
    SqliteStore(path).close()
    database = sqlite3.connect(path)
    database.execute('DELETE FROM history')
    database.commit()
    database.close()
    with pytest.raises(JournalUnusable, match='the table history is empty'):
        SqliteStore(path)


def test_the_events_name_their_history(path: Path) -> None:
    run = LongRun(path, Line(faults={'a2': '#2=abort'}))
    run.orchestrator.settle()
    (first,) = run.store.read(156, 1)
    assert isinstance(first, OrchestratorStarted)
    assert first.history == run.orchestrator.state.history == run.store.history
    run.close()
