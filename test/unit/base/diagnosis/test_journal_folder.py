"""Whether a journal can live in a folder: tried with real locks and a real database."""

from __future__ import annotations

from pathlib import Path

import pytest

from bt_orchestrator.base.diagnosis import journal_folder as module
from bt_orchestrator.base.diagnosis.check import Verdict
from bt_orchestrator.base.diagnosis.journal_folder import journal_folder


def test_a_folder_of_the_local_disk(tmp_path: Path) -> None:
    check = journal_folder(tmp_path)
    assert (check.verdict, check.found) == (
        Verdict.OK,
        f'{tmp_path} can be written, locks work',
    )
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_the_journal_would_make(tmp_path: Path) -> None:
    assert journal_folder(tmp_path / 'journals' / 'cell').verdict is Verdict.OK
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_written() -> None:
    check = journal_folder(Path('/proc/self'))
    assert check.verdict is Verdict.FAIL
    assert check.found.startswith('/proc/self cannot be written: ')


def test_locks_that_keep_nobody_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As on a network disk whose locks are of one computer: the other one gets the lock too."""
    monkeypatch.setattr(module, '_TRY_LOCK', 'pass')
    check = journal_folder(tmp_path)
    assert check.verdict is Verdict.FAIL
    assert 'two nodes could use one journal' in check.found
