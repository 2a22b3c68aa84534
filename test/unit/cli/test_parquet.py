"""The verb `events --format parquet`, on a journal file."""

from __future__ import annotations

import shutil
import sqlite3
import sys
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from bt_orchestrator.cli import events as verb
from bt_orchestrator.cli.main import INTERRUPTED, main

SCHEMA_1 = Path(__file__).parents[2] / 'data' / 'journal_schema_1.sqlite3'


@pytest.fixture
def journal(tmp_path: Path) -> Path:
    return Path(shutil.copy(SCHEMA_1, tmp_path / 'journal.sqlite3'))


def events(journal: Path, *words: str) -> int:
    return main(['events', '--journal', str(journal), '--format', 'parquet', *words])


def test_a_folder_of_tables(journal: Path, tmp_path: Path) -> None:
    pq = pytest.importorskip(
        'pyarrow.parquet', reason='needs pyarrow: ./scripts/bootstrap --parquet'
    )
    out = tmp_path / 'new' / 'folder'
    assert events(journal, '-o', str(out)) == 0
    assert pq.read_table(out / 'events.parquet')['seq'].to_pylist() == list(range(1, 157))
    tasks = pq.read_table(out / 'tasks.parquet').to_pylist()
    assert sum(row['outcome'] == 'failed' for row in tasks) == 1
    assert events(journal, '-o', str(out), '--job', 'J2') == 0
    assert set(pq.read_table(out / 'tasks.parquet')['job'].to_pylist()) == {'J2'}


def test_a_damaged_record_is_left_out_and_said(
    journal: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pq = pytest.importorskip(
        'pyarrow.parquet', reason='needs pyarrow: ./scripts/bootstrap --parquet'
    )
    with closing(sqlite3.connect(journal)) as database, database:
        database.execute("UPDATE events SET record = 'x' WHERE seq = 100")
    assert events(journal, '-o', str(tmp_path / 'out')) == 1
    assert 'event 100' in capsys.readouterr().err
    seqs = pq.read_table(tmp_path / 'out' / 'events.parquet')['seq'].to_pylist()
    assert 100 not in seqs
    assert len(seqs) == 155


def test_what_is_interrupted_leaves_the_tables_of_before(
    journal: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pq = pytest.importorskip(
        'pyarrow.parquet', reason='needs pyarrow: ./scripts/bootstrap --parquet'
    )
    out = tmp_path / 'out'
    assert events(journal, '-o', str(out), '--count', '3') == 0

    def interrupted(*_: object) -> Iterator[str]:
        yield '{"seq": 7, "time": 0.0, "event": "x"}'
        raise KeyboardInterrupt

    monkeypatch.setattr(verb, '_records', interrupted)
    assert events(journal, '-o', str(out)) == INTERRUPTED
    assert pq.read_table(out / 'events.parquet')['seq'].to_pylist() == [1, 2, 3]
    assert len(list(out.iterdir())) == 2


@pytest.mark.parametrize(
    ('words', 'message'),
    [
        ((), 'parquet is two tables in a folder; name it: -o FOLDER'),
        (('-o', 'x', '--follow'), 'parquet is written when all events are known'),
    ],
)
def test_wrong_use(
    journal: Path, capsys: pytest.CaptureFixture[str], words: tuple[str, ...], message: str
) -> None:
    assert events(journal, *words) == 2
    assert message in capsys.readouterr().err


def test_a_folder_that_cannot_be_written(
    journal: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip('pyarrow', reason='needs pyarrow: ./scripts/bootstrap --parquet')
    assert events(journal, '-o', str(journal)) == 2
    assert f'cannot write {journal}: File exists' in capsys.readouterr().err


def test_missing_package_error_says_how_to_install(
    journal: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, 'pyarrow', None)
    assert events(journal, '-o', 'out') == 2
    assert "pip install 'pyarrow>=15'" in capsys.readouterr().err
