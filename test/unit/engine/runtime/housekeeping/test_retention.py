"""Retention makes the file short: old events go, and nothing that is so."""

from __future__ import annotations

import itertools
import json
import sqlite3
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from fakes.journal_states import change, kept, restored
from fakes.line import THREE, Line, with_section
from fakes.long_journal import LongRun
from fakes.reading import Reading as ReadingLine
from fakes.virtual_run import snapshot

from bt_orchestrator.base.errors import JournalMismatch
from bt_orchestrator.engine.runtime import housekeeping
from bt_orchestrator.model.events import ItemIdentified
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.keeping.snapshot import Writer
from bt_orchestrator.model.limits import ENDED_KEPT
from bt_orchestrator.model.state import CellState
from bt_orchestrator.store.sqlite.store import SqliteStore

AT_REST = housekeeping.AT_REST


def jobs_of(path: Path) -> list[str]:
    database = sqlite3.connect(path)
    query = "SELECT DISTINCT json_extract(record, '$.job') FROM events"
    names = [job for (job,) in database.execute(query) if job]
    database.close()
    return names


def test_old_jobs_lose_their_events_and_nothing_else(path: Path) -> None:
    run = LongRun(path, keep_jobs=2)
    for n in range(1, 6):
        run.job(f'J{n}')
        run.rest(3)
    state = run.orchestrator.state
    first = run.store.first_seq()
    run.kill()
    assert first > 100
    assert jobs_of(path) == ['J4', 'J5']
    assert snapshot(restored(path)) == snapshot(state)
    change(path, 'DELETE FROM snapshots')
    assert snapshot(restored(path)) == snapshot(state)
    change(path, "UPDATE beginning SET stamp = 'an older program'")
    assert snapshot(restored(path)) == snapshot(state)
    database = sqlite3.connect(path)
    summaries = database.execute('SELECT job FROM jobs ORDER BY job').fetchall()
    database.close()
    assert summaries == [(f'J{n}',) for n in range(1, 6)]


def test_live_jobs_keep_all_their_events(path: Path) -> None:
    line = Line(faults={'a2': '#1=abort'})
    run = LongRun(path, line, keep_jobs=0)
    text = with_section(2, '- {id: work, @b2}')
    assert run.orchestrator.ask(AddJobs((Job('OLD', line.script(text), 2),))).accepted
    assert is_queued(run, 'LIVE')
    assert is_queued(run, 'LATER')
    run.go(lambda: bool(run.orchestrator.state.holds) and 'OLD' in run.orchestrator.state.ended)
    run.rest(5)
    state = run.orchestrator.state
    run.kill()
    assert list(state.jobs) == ['LIVE', 'LATER']
    database = sqlite3.connect(path)
    query = 'SELECT record FROM events ORDER BY seq LIMIT 1'
    first = json.loads(database.execute(query).fetchone()[0])
    database.close()
    assert (first['event'], first['job']) == ('job.queued', 'LIVE')
    assert snapshot(restored(path, line)) == snapshot(state)


def is_queued(run: LongRun, name: str) -> bool:
    return run.orchestrator.ask(AddJobs((Job(name, run.line.script(THREE), 3),))).accepted


def test_6_8_serials_outlive_their_events(path: Path) -> None:
    reading = ReadingLine(faults='"#*=reads:1"')
    run = LongRun(path, reading, keep_jobs=0)  # type: ignore[arg-type]
    run.job('J1', 1, '')
    run.rest(60)
    assert run.store.first_seq() > 1
    assert not any(isinstance(event, ItemIdentified) for event in run.store.read())
    run.kill()
    run = LongRun(path, reading, keep_jobs=0)  # type: ignore[arg-type]
    assert 'S-1' in run.orchestrator.state.serials
    assert run.orchestrator.ask(AddJobs((Job('J2', reading.script(), 1),))).accepted
    run.go(lambda: bool(run.orchestrator.state.holds))
    (hold,) = run.orchestrator.state.holds.values()
    assert hold.reason == 'duplicate_serial'
    run.kill()


def test_many_events_go_in_small_pieces(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr('bt_orchestrator.store.shared.rows.BATCH', 10)
    run = LongRun(path, keep_jobs=0)
    run.job('J1')
    end = run.orchestrator.state.seq
    firsts: list[int] = []
    while not firsts or firsts[-1] <= end:
        run.rest(1)
        firsts.append(run.store.first_seq())
    steps = [after - before for before, after in itertools.pairwise(firsts)]
    assert 0 < max(steps) <= 10
    run.kill()


def test_nothing_goes_before_there_are_too_many(path: Path) -> None:
    run = LongRun(path, keep_jobs=2)
    run.job('J1')
    run.job('J2')
    run.rest(3)
    assert run.store.first_seq() == 1
    assert run.store.beginning() is None
    run.kill()


def test_nothing_goes_that_replay_needs(path: Path) -> None:
    run = LongRun(path)
    run.job('J1')
    assert not run.store.remove_batch(50)
    assert run.store.first_seq() == 1
    run.kill()


def test_state_that_changes_on_reload_removes_nothing(
    path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    fields_of = Writer.fields_of

    def forgetful(writer: Writer, state: CellState) -> dict[str, Any]:
        fields = fields_of(writer, state)
        del fields['beat']
        return fields

    monkeypatch.setattr(Writer, 'fields_of', forgetful)
    run = LongRun(path, keep_jobs=0)
    run.job('J1')
    run.rest(3)
    assert 'the state cannot be kept (beat would change)' in caplog.text
    assert run.store.first_seq() == 1
    assert run.store.beginning() is None
    run.kill()


def test_busy_line_cleans_up_ended_jobs_together(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A snapshot and a look through all jobs for each one took more than the jobs themselves."""
    monkeypatch.setattr(housekeeping, 'AT_REST', AT_REST)
    run = LongRun(path, keep_jobs=20)
    run.housekeeping._journal = journal = Counted(run.store)
    jobs = 150
    for n in range(1, jobs + 1):
        run.job(f'J{n}', 1)
    most = 3
    by_events = run.orchestrator.state.seq // housekeeping.SNAPSHOT_EVERY
    assert 1 <= journal.calls['save'] <= most + by_events
    assert 1 <= journal.calls['first_needed'] <= most
    assert 1 <= journal.calls['begin_with'] <= most
    run.rest(AT_REST + 5)
    run.kill()
    database = sqlite3.connect(path)
    query = "SELECT json_extract(record, '$.job') FROM events WHERE record LIKE '%\"job.queued\"%'"
    queued = [job for (job,) in database.execute(query)]
    assert queued == [f'J{n}' for n in range(jobs - 19, jobs + 1)]
    assert database.execute('SELECT count(*) FROM jobs').fetchone()[0] == jobs
    database.close()


def test_turns_are_wanted_until_all_is_stored(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(housekeeping, 'AT_REST', AT_REST)
    monkeypatch.setattr('bt_orchestrator.store.shared.rows.BATCH', 10)
    run = LongRun(path, keep_jobs=0)
    assert turns_until_stored(run) == 0, 'nothing has happened'
    run.job('J1')
    run.rest(1)
    assert turns_until_stored(run) > AT_REST

    stored = kept_now(run)
    assert stored[0] > 80, 'the events of J1 are gone'
    run.rest(2 * AT_REST)
    assert kept_now(run) == stored
    run.kill()


def turns_until_stored(run: LongRun) -> int:
    turns = 0
    while run.housekeeping.wants_turns:
        run.rest(1)
        turns += 1
    return turns


def kept_now(run: LongRun) -> tuple[int, list[int]]:
    return run.store.first_seq(), [kept.seq for kept in run.store.snapshots()]


def test_busy_line_records_every_job(path: Path) -> None:
    run = LongRun(path)
    jobs = 2 * ENDED_KEPT
    for n in range(1, jobs + 1):
        assert run.orchestrator.ask(AddJobs((Job(f'J{n}', run.line.script(THREE), 1),))).accepted
        while run.orchestrator.state.jobs:
            assert run.clock.advance()
            run.orchestrator.settle()
            run.housekeeping.turn(quiet=False)
    run.close()
    database = sqlite3.connect(path)
    assert database.execute('SELECT count(*) FROM jobs').fetchone()[0] == jobs
    database.close()


class Counted:
    """A journal that counts what is asked of it."""

    def __init__(self, store: SqliteStore) -> None:
        self._store = store
        self.calls: Counter[str] = Counter()

    def __getattr__(self, name: str) -> Any:
        self.calls[name] += 1
        return getattr(self._store, name)


def test_everything_is_kept_on_demand(path: Path) -> None:
    run = LongRun(path, keep_jobs=housekeeping.KEEP_ALL)
    run.job('J1')
    run.job('J2')
    run.rest(3)
    assert run.store.first_seq() == 1
    run.kill()


def test_a_damaged_beginning_is_refused_in_words(path: Path) -> None:
    run = LongRun(path, keep_jobs=0)
    run.job('J1')
    run.rest(3)
    run.kill()
    change(path, 'DELETE FROM snapshots')
    change(path, "UPDATE beginning SET state = '{}', checksum = ''")
    with pytest.raises(Exception, match='holds a record that cannot be read: ValueError'):
        restored(path)


def test_beginning_of_another_cell_is_refused(path: Path) -> None:
    run = LongRun(path, keep_jobs=0)
    run.job('J1')
    run.rest(3)
    assert is_queued(run, 'J2')
    run.go(lambda: run.orchestrator.state.sections[3].slot is not None)
    run.store.begin_with(kept(run.orchestrator.state))
    run.kill()
    with pytest.raises(JournalMismatch, match=r'begins with a state, at event \d+, that does not'):
        restored(path, Line(2))
