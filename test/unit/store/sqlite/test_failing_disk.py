"""Full disks, files that cannot be written, damaged files: said in words, and nothing is lost."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from fakes import until_broken
from fakes.commands import AnswerHold
from fakes.line import Line
from fakes.long_journal import LongRun
from fakes.operator import ann
from fakes.other_python import run_python

from bt_orchestrator.engine.runtime.recovery import restore
from bt_orchestrator.store.sqlite.store import SqliteStore

NOBODY = 65534

OPEN = """
import os, sys
from pathlib import Path
from bt_orchestrator.store.sqlite.store import SqliteStore
from bt_orchestrator.base.errors import OrchestratorError
os.setuid(int(sys.argv[2]))
try:
    SqliteStore(Path(sys.argv[1])).close()
except OrchestratorError as error:
    print(error)
"""


@pytest.fixture
def folder() -> Iterator[Path]:
    """Give a folder that other users may look into."""
    with tempfile.TemporaryDirectory() as name:
        Path(name).chmod(0o755)
        yield Path(name)
        Path(name).chmod(0o755)


@pytest.mark.parametrize('room', [60_000, 100_000])
def test_full_disk_stops_cell_but_keeps_durable_work(tmp_path: Path, room: int) -> None:
    path = tmp_path / 'journal.sqlite3'
    report: dict[str, Any] = json.loads(run_python(until_broken.__file__, str(path), str(room)))
    assert 'cannot be written' in report['broken']
    assert 'nothing is sent any more' in report['broken']
    assert report['pause'] is False

    run = LongRun(path)  # there is room again
    seqs = [event.seq for event in run.store.read()]
    assert seqs == list(range(1, report['seq'] + 1))  # what was shown is what was kept
    assert list(run.orchestrator.state.jobs) == report['live']
    while run.orchestrator.state.jobs:
        run.orchestrator.settle()
        for hold in list(run.orchestrator.state.holds):  # controllers of another process
            assert run.orchestrator.ask(AnswerHold(hold, 'mark_done', ann('seen'))).accepted
        run.clock.advance()
    run.job('LAST')
    run.close()


def test_unwritable_journal_is_refused_at_once(folder: Path) -> None:
    path = folder / 'journal.sqlite3'
    SqliteStore(path).close()
    user = str(NOBODY if os.geteuid() == 0 else os.geteuid())
    path.chmod(0o444)
    path.with_name(path.name + '.lock').chmod(0o666)
    folder.chmod(0o777)
    denied = f'the journal {path} cannot be opened: Permission denied; check file and folder'
    assert run_python('-c', OPEN, str(path), user) == denied
    path.chmod(0o666)
    folder.chmod(0o555)
    assert run_python('-c', OPEN, str(path), user) == denied
    path.with_name(path.name + '.lock').unlink()
    assert run_python('-c', OPEN, str(path), user) == denied


def restored(path: Path) -> None:
    store = SqliteStore(path)
    try:
        restore(Line().cell, store)
    finally:
        store.close()
