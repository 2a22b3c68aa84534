"""Snapshots make the next start short, retention the file; neither changes what is so."""

from __future__ import annotations

import itertools
import json
import logging
import math
import shutil
import sqlite3
from collections import Counter
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest
from fakes.line import THREE, Line, with_section
from fakes.long_journal import LongRun
from fakes.operator import ann
from fakes.reading import Reading as ReadingLine
from fakes.virtual_run import snapshot

from bt_orchestrator import model
from bt_orchestrator.errors import JournalFailed, JournalMismatch
from bt_orchestrator.model.events import Event, ItemIdentified
from bt_orchestrator.model.fold import apply
from bt_orchestrator.model.jobs.job_commands import AddJobs, ControlJob
from bt_orchestrator.model.jobs.job_folds import ENDED_KEPT
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.keeping import state_text
from bt_orchestrator.model.keeping.snapshot import Writer, state_from_plain, state_to_plain
from bt_orchestrator.model.state import CellState, Reading
from bt_orchestrator.ports import Snapshot
from bt_orchestrator.runtime import housekeeping, recovery
from bt_orchestrator.runtime.recovery import restore
from bt_orchestrator.store.sqlite.store import SqliteStore

LINE = Line()
AT_REST = housekeeping.AT_REST


@pytest.fixture(autouse=True)
def soon_at_rest(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let one quiet moment be rest enough, so that a job is looked after when it has ended."""
    monkeypatch.setattr(housekeeping, 'AT_REST', 1)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / 'journal.sqlite3'


@pytest.fixture
def often(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make snapshots after 20 events."""
    monkeypatch.setattr(housekeeping, 'SNAPSHOT_EVERY', 20)


def change(path: Path, statement: str) -> None:
    database = sqlite3.connect(path)
    database.execute(statement)
    database.commit()
    database.close()


def restored(path: Path, line: Line = LINE) -> CellState:
    store = SqliteStore(path)
    try:
        return restore(line.cell, store)
    finally:
        store.close()


def kept(state: CellState) -> Snapshot:
    text = json.dumps(state_to_plain(state))
    return Snapshot(state.seq, recovery.stamp(state.cell), text)


def replayed(path: Path) -> CellState:
    """Return what the events alone tell of."""
    change(path, 'DELETE FROM snapshots')
    return restored(path)


@pytest.fixture
def replays(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Count the events that every start replays."""
    found: list[int] = []

    def counting(state: CellState, event: Event) -> None:
        found.append(state.seq)
        apply(state, event)

    monkeypatch.setattr('bt_orchestrator.runtime.recovery.apply', counting)
    return found


def test_a_start_replays_what_came_after_the_last_snapshot(
    path: Path, often: None, replays: list[int]
) -> None:
    run = LongRun(path)
    run.job('J1')
    run.job('J2')
    state = run.orchestrator.state
    replays.clear()
    run.kill()
    again = restored(path)
    assert snapshot(again) == snapshot(state)
    assert len(replays) < 25
    replays.clear()
    assert snapshot(replayed(path)) == snapshot(state)
    assert len(replays) == state.seq > 150


def test_a_start_after_an_end_in_order_replays_nothing(path: Path, replays: list[int]) -> None:
    run = LongRun(path)
    run.job('J1')
    run.close()
    replays.clear()
    assert restored(path).ended.keys() == {'J1'}
    assert replays == []


def test_a_line_that_is_never_quiet_gets_its_snapshots(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(housekeeping, 'SNAPSHOT_AT_LATEST', 50)
    run = LongRun(path)
    run.housekeeping.turn(quiet=False)
    assert not list(run.store.snapshots())
    run.job('J1', 10)
    before = next(iter(run.store.snapshots())).seq
    run.orchestrator.settle()
    for name in 'ABCDEFGHIJKLMNOPQRSTUVWXYZ':
        run.job(name, 1)
        run.housekeeping.turn(quiet=False)
    assert next(iter(run.store.snapshots())).seq > before
    run.close()


@pytest.mark.parametrize(
    ('damage', 'warning'),
    [
        ('state = replace(state, \'"beat"\', \'"beta"\')', 'is damaged'),
        ("checksum = 'x'", 'is damaged'),
    ],
)
def test_a_damaged_snapshot_is_ignored_and_said(
    path: Path,
    damage: str,
    warning: str,
    replays: list[int],
    caplog: pytest.LogCaptureFixture,
) -> None:
    run = LongRun(path)
    run.job('J1')
    state = run.orchestrator.state
    run.close()
    replays.clear()
    change(path, f'UPDATE snapshots SET {damage}')
    assert snapshot(restored(path)) == snapshot(state)
    assert len(replays) == state.seq
    assert warning in caplog.text


def test_the_snapshot_before_a_damaged_one_is_used(
    path: Path, often: None, replays: list[int]
) -> None:
    run = LongRun(path)
    run.job('J1')
    run.close()
    replays.clear()
    change(path, "UPDATE snapshots SET checksum = '' WHERE seq = (SELECT max(seq) FROM snapshots)")
    restored(path)
    assert 0 < len(replays) < 40


def test_a_snapshot_of_another_program_is_ignored(
    path: Path, replays: list[int], caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO)
    run = LongRun(path)
    run.job('J1')
    state = run.orchestrator.state
    run.close()
    replays.clear()
    change(path, "UPDATE snapshots SET stamp = 'older'")
    assert snapshot(restored(path)) == snapshot(state)
    assert len(replays) == state.seq
    assert 'is of another program or cell' in caplog.text


def test_a_snapshot_that_the_events_contradict_is_ignored(
    path: Path, often: None, caplog: pytest.LogCaptureFixture
) -> None:
    run = LongRun(path)
    run.job('J1')
    run.kill()
    expected = snapshot(replayed(path))
    store = SqliteStore(path)
    other = CellState(LINE.cell)
    other.seq = 30
    store.save(kept(other))
    store.close()
    assert snapshot(restored(path)) == expected
    assert 'the snapshot at event 30 is ignored' in caplog.text


def test_the_stamp_names_the_cell() -> None:
    assert recovery.stamp(LINE.cell) == recovery.stamp(Line().cell)
    assert recovery.stamp(LINE.cell) != recovery.stamp(Line(4).cell)


# --- retention ------------------------------------------------------------------------------


def jobs_of(path: Path) -> list[str]:
    database = sqlite3.connect(path)
    query = "SELECT DISTINCT json_extract(record, '$.job') FROM events"
    found = [job for (job,) in database.execute(query) if job]
    database.close()
    return found


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
    monkeypatch.setattr('bt_orchestrator.store.sqlite.retention.BATCH', 10)
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


def test_nothing_goes_for_a_state_that_does_not_come_back(
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


def test_a_line_at_work_looks_after_its_ended_jobs_together(
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


def test_a_line_that_is_never_quiet_notes_every_job(path: Path) -> None:
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


def test_a_beginning_of_another_cell_is_refused_in_words(path: Path) -> None:
    run = LongRun(path, keep_jobs=0)
    run.job('J1')
    run.rest(3)
    assert is_queued(run, 'J2')
    run.go(lambda: run.orchestrator.state.sections[3].slot is not None)
    run.store.begin_with(kept(run.orchestrator.state))
    run.kill()
    with pytest.raises(JournalMismatch, match=r'begins with a state, at event \d+, that does not'):
        restored(path, Line(2))


class FullDisk(SqliteStore):
    """A journal that takes events and nothing else."""

    def save(self, *_: object) -> None:
        raise JournalFailed('the journal x cannot be written: disk full')


def test_a_snapshot_that_fails_harms_nothing(path: Path, caplog: pytest.LogCaptureFixture) -> None:
    run = LongRun(path)
    full = FullDisk(path.with_name('other.sqlite3'))
    run.housekeeping._journal = full
    run.job('J1')
    caplog.clear()
    run.rest(20)
    assert caplog.text == ''  # not again before something has happened
    run.housekeeping._journal = run.store
    run.job('J2')
    assert [snapshot.seq for snapshot in run.store.snapshots()]
    rows = run.store._database.execute('SELECT job FROM jobs').fetchall()
    assert sorted(rows) == [('J1',), ('J2',)]
    run.housekeeping._journal = full
    run.job('J3')
    run.close()
    full.close()
    assert 'disk full: no snapshot, nothing removed; tried again later' in caplog.text
    assert restored(path).ended.keys() == {'J1', 'J2', 'J3'}


def test_every_file_of_the_rules_names_the_program(tmp_path: Path) -> None:
    folder = Path(shutil.copytree(Path(str(files(model))), tmp_path / 'model'))
    before = recovery.program_in(folder)
    sources = list(folder.rglob('*.py'))
    assert folder / 'events' / 'base.py' in sources
    for file in sources:
        text = file.read_text()
        file.write_text(f'{text}\n# changed\n')
        assert recovery.program_in(folder) != before, file
        file.write_text(text)
        assert recovery.program_in(folder) == before
        moved = file.rename(file.with_name('moved.py'))
        assert recovery.program_in(folder) != before, file
        moved.rename(file)
    assert recovery.program_in(folder) == before == recovery._program()


def test_a_state_with_a_text_that_has_no_utf8_is_kept(path: Path) -> None:
    """Half a surrogate pair, as a script or a result may have it; nan as well."""
    state, store = CellState(LINE.cell), SqliteStore(path)
    state.readings['a1'] = Reading(ready=True, value=['a\ud800', math.nan])
    housekeeper = housekeeping.Housekeeping(state, store)
    state.seq = 1
    housekeeper.finish()
    (kept,) = store.snapshots()
    store.close()
    again = state_from_plain(LINE.cell, json.loads(kept.state))
    assert again.readings == state.readings


# --- a long queue ---------------------------------------------------------------------------


@pytest.fixture
def small_slices(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(state_text, 'SLICE', 10)


def queue_many(run: LongRun) -> None:
    script = run.line.script(THREE)
    jobs = tuple(Job(f'Q-{n}', script, 1) for n in range(55))
    assert run.orchestrator.ask(AddJobs(jobs)).accepted


def test_the_state_of_a_long_queue_is_written_in_slices_while_the_line_goes_on(
    path: Path, often: None, small_slices: None, replays: list[int]
) -> None:
    run = LongRun(path)
    queue_many(run)
    begun = run.orchestrator.state.seq
    for turn in range(6):
        assert not list(run.store.snapshots()), turn
        run.housekeeping.turn(quiet=turn == 0)
        assert run.clock.advance()
        run.orchestrator.settle()
        if turn == 2:
            last = ControlJob('cancel', 'Q-54', ann())
            assert run.orchestrator.ask(last).accepted
    (kept_state,) = run.store.snapshots()
    state = run.orchestrator.state
    assert kept_state.seq == begun < state.seq
    assert len(state.queue) < 54
    run.kill()
    replays.clear()
    assert snapshot(restored(path)) == snapshot(state)
    assert len(replays) == state.seq - begun


def test_a_job_that_ends_in_front_of_a_long_queue_has_not_all_of_it_written(
    path: Path, often: None
) -> None:
    run = LongRun(path)
    queue_many(run)
    run.rest(3)
    first = [one.seq for one in run.store.snapshots()]
    while len(run.orchestrator.state.ended) < 4:
        assert run.clock.advance()
        run.orchestrator.settle()
        run.rest(1)
        seqs = [one.seq for one in run.store.snapshots()]
        assert seqs[0] == first[0] or seqs[0] - first[0] > len(run.orchestrator.state.queue)
    assert len(seqs) == 2
    run.kill()


@pytest.mark.parametrize('is_forgetful', [False, True])
def test_every_job_of_a_long_queue_is_read_back_before_events_go(
    path: Path,
    is_forgetful: bool,
    small_slices: None,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    run = LongRun(path)
    run.job('J1')
    run.housekeeping = housekeeping.Housekeeping(run.orchestrator.state, run.store, 0)
    queue_many(run)
    assert run.orchestrator.ask(ControlJob('hold', 'Q-40', ann())).accepted
    write_fields = Writer.write_fields

    def forgetful(writer: Writer, kind: type, value: Any) -> dict[str, Any]:
        fields = write_fields(writer, kind, value)
        fields.pop('held', None)
        return fields

    if is_forgetful:
        monkeypatch.setattr(Writer, 'write_fields', forgetful)
    run.rest(20)
    assert ('the state cannot be kept (job Q-40 would change)' in caplog.text) is is_forgetful
    assert (run.store.beginning() is None) is is_forgetful
    run.kill()
