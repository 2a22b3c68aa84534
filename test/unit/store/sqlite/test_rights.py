"""What is in a journal is for its owner: files are made so, and wider ones are told."""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Iterator
from pathlib import Path

import pytest

from bt_orchestrator.base.diagnosis.check import Verdict
from bt_orchestrator.cli.doctor import _rights
from bt_orchestrator.model.events import JobStarted
from bt_orchestrator.store.sqlite.restoring import bring_back
from bt_orchestrator.store.sqlite.store import SqliteStore


@pytest.fixture(autouse=True)
def _umask() -> Iterator[None]:
    before = os.umask(0o022)
    yield
    os.umask(before)


def written(path: Path) -> SqliteStore:
    store = SqliteStore(path)
    store.append([JobStarted(seq=1, time=1.0, job='WO-1')])
    return store


def modes(folder: Path) -> dict[str, int]:
    return {file.name: file.stat().st_mode & 0o777 for file in folder.iterdir()}


def test_every_file_and_folder_is_private(tmp_path: Path) -> None:
    path = tmp_path / 'new' / 'line' / 'journal'
    store = written(path)
    endings = ('', '-wal', '-shm', '-mark', '.lock')
    assert modes(path.parent) == {f'journal{ending}': 0o600 for ending in endings}
    store.close()
    assert modes(tmp_path) == {'new': 0o700}
    assert modes(tmp_path / 'new') == {'line': 0o700}
    bring_back(path, tmp_path / 'back' / 'journal')
    assert set(modes(tmp_path / 'back').values()) == {0o600}


def test_wider_rights_are_left_and_told(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    path = tmp_path / 'journal'
    written(path).close()
    assert 'others than its owner' not in caplog.text
    path.chmod(0o640)
    SqliteStore(path).close()
    assert 'others than its owner may open journal (0640)' in caplog.text
    assert path.stat().st_mode & 0o777 == 0o640


def test_doctor_tells_them(tmp_path: Path) -> None:
    path = tmp_path / 'journal'
    assert list(_rights(path)) == []
    written(path).close()
    assert [check.verdict for check in _rights(path)] == [Verdict.OK]
    path.chmod(0o604)
    (check,) = _rights(path)
    assert check.verdict is Verdict.WARN
    assert 'may open journal (0604)' in check.found
    assert check.remedy.startswith(f'chmod 600 {path}*')


def test_a_reader_of_the_group_reads_on(tmp_path: Path) -> None:
    path = tmp_path / 'journal'
    written(path).close()
    path.chmod(0o640)
    store = SqliteStore(path)
    store.append([JobStarted(seq=2, time=2.0, job='WO-2')])
    assert modes(tmp_path)['journal-wal'] == 0o640
    reader = sqlite3.connect(f'file:{path}?mode=ro', uri=True)
    assert reader.execute('SELECT count(*) FROM events').fetchone() == (2,)
    reader.close()
    store.close()
