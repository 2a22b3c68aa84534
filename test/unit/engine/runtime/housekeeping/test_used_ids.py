"""Serials and order ids that do not count up: few stand in a snapshot, whatever their number."""

from __future__ import annotations

import json
import random
import sqlite3
from pathlib import Path

import pytest
from fakes.journal_states import change, restored
from fakes.long_journal import LongRun
from fakes.reading import Reading
from fakes.virtual_run import snapshot

from bt_orchestrator.base.errors import JournalUnusable
from bt_orchestrator.engine.runtime.housekeeping import KEEP_ALL
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.judging import used_ids
from bt_orchestrator.model.judging.used_ids import SealedIds
from bt_orchestrator.model.state import CellState


def entries(run: LongRun) -> list[int]:
    """Return how many ids, and runs of them, stand in each set of the newest snapshot."""
    newest = next(iter(run.store.snapshots()))
    sets = [obj for obj in json.loads(newest.state)['objects'] if {'others', 'runs'} & obj.keys()]
    return [
        len(obj.get('others', [])) + sum(map(len, obj.get('runs', {}).values())) for obj in sets
    ]


def test_snapshot_work_stays_constant_with_random_serials(path: Path) -> None:
    run, drawn = LongRun(path), random.Random(1)
    for n in range(3):
        for _ in range(10_000):
            run.orchestrator.state.serials.add(f'{drawn.getrandbits(64):016x}')
        run.job(f'J{n}', 1)
        run.rest(20)
        assert max(entries(run)) <= 5000
    run.close()


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let a part be full with three ids."""
    monkeypatch.setattr(used_ids, 'FULL', 3)


def letters(run: LongRun, jobs: str, retain: int = KEEP_ALL) -> CellState:
    """Run jobs whose ids, the letters, do not count up, and let them be looked after."""
    run.housekeeping._keep_jobs = retain
    for name in jobs:
        run.job(name, 1)
        run.rest(20)
    return run.orchestrator.state


def copies(path: Path) -> list[tuple[str, int]]:
    database = sqlite3.connect(path)
    rows = database.execute('SELECT digest, copy FROM used_ids ORDER BY rowid').fetchall()
    database.close()
    return rows


def test_full_part_is_written_once_and_restored(few: None, path: Path) -> None:
    run = LongRun(path)
    written: list[str] = []
    keep_used = run.store.keep_used

    def counting(part: SealedIds) -> None:
        written.append(part.digest)
        keep_used(part)

    run.store.keep_used = counting  # type: ignore[method-assign]
    state = letters(run, 'ABCDEFGH')
    assert written == state.order_ids.sealed
    assert len(written) == 2
    run.kill()
    again = LongRun(path)
    reloaded = again.orchestrator.state
    assert [name for name in 'ABCDEFGHI' if name in reloaded.order_ids] == list('ABCDEFGH')
    assert reloaded.order_ids == state.order_ids
    letters(again, 'I')
    assert len(again.orchestrator.state.order_ids.sealed) == 3
    again.close()
    assert len(copies(path)) == 6


def test_what_is_sealed_outlives_its_events(few: None, path: Path) -> None:
    run = LongRun(path, keep_jobs=0)
    state = letters(run, 'ABCDEFGH', retain=0)
    assert run.store.first_seq() > 1
    run.kill()
    change(path, 'DELETE FROM snapshots')
    reloaded = restored(path)
    assert snapshot(reloaded) == snapshot(state)
    assert all(name in reloaded.order_ids for name in 'ABCDEFGH')


@pytest.mark.parametrize(
    'harm', ["UPDATE used_ids SET ids = replace(ids, 'B', 'X')", 'DELETE FROM used_ids']
)
@pytest.mark.parametrize('copy', [1, 2])
def test_one_damaged_copy_is_told_and_written_again(
    few: None, path: Path, copy: int, harm: str, caplog: pytest.LogCaptureFixture
) -> None:
    run = LongRun(path, keep_jobs=0)
    letters(run, 'ABCDEFGH', retain=0)
    run.kill()
    change(path, f'{harm} WHERE copy = {copy}')
    again = LongRun(path)
    assert 'the journal has 1 of 2 copies of the used ids' in caplog.text
    assert all(name in again.orchestrator.state.order_ids for name in 'ABCDEFGH')
    letters(again, 'I')
    again.kill()
    caplog.clear()
    restored(path)
    assert not caplog.text


def test_lost_copies_are_replayed_and_rewritten(
    few: None, path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    run = LongRun(path)
    letters(run, 'ABCDEFGH')
    run.kill()
    change(path, "UPDATE used_ids SET ids = ''")
    again = LongRun(path)
    assert 'is ignored' in caplog.text
    state = letters(again, 'I')
    again.kill()
    caplog.clear()
    reloaded = restored(path)
    assert not caplog.text
    assert reloaded.order_ids == state.order_ids
    assert all(name in reloaded.order_ids for name in 'ABCDEFGHI')


def test_journal_without_used_ids_is_refused(few: None, path: Path) -> None:
    run = LongRun(path, keep_jobs=0)
    letters(run, 'ABCDEFGH', retain=0)
    run.kill()
    change(path, 'DELETE FROM used_ids')
    with pytest.raises(JournalUnusable, match='would not be noticed if one is used again'):
        restored(path)


def test_6_8_sealed_serial_is_duplicate_after_restart(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(used_ids, 'FULL', 1)
    reading = Reading(faults='"#*=reads:1"')
    run = LongRun(path, reading, keep_jobs=0)  # type: ignore[arg-type]
    run.job('J1', 1, '')
    run.rest(60)
    assert not run.orchestrator.state.serials.runs
    run.kill()
    run = LongRun(path, reading, keep_jobs=0)  # type: ignore[arg-type]
    assert run.orchestrator.ask(AddJobs((Job('J2', reading.script(), 1),))).accepted
    run.go(lambda: bool(run.orchestrator.state.holds))
    (hold,) = run.orchestrator.state.holds.values()
    assert hold.reason == 'duplicate_serial'
    run.kill()
