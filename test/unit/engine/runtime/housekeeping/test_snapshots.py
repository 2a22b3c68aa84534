"""Snapshots make the next start short, and change nothing."""

from __future__ import annotations

import json
import logging
import math
import shutil
from importlib.resources import files
from pathlib import Path

import pytest
from fakes.journal_states import LINE, change, kept, replayed, restored
from fakes.line import Line
from fakes.long_journal import LongRun
from fakes.virtual_run import snapshot

from bt_orchestrator import model
from bt_orchestrator.base.errors import JournalFailed
from bt_orchestrator.engine.runtime import housekeeping, recovery
from bt_orchestrator.model.keeping.snapshot import state_from_plain
from bt_orchestrator.model.state import CellState, Reading
from bt_orchestrator.store.sqlite.store import SqliteStore


def test_start_replays_events_after_last_snapshot(
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


def test_start_after_clean_end_replays_nothing(path: Path, replays: list[int]) -> None:
    run = LongRun(path)
    run.job('J1')
    run.close()
    replays.clear()
    assert restored(path).ended.keys() == {'J1'}
    assert replays == []


def test_busy_line_gets_snapshots(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
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


def test_state_with_invalid_utf8_text_is_kept(path: Path) -> None:
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
