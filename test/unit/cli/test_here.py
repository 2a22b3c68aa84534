"""The cell file and the journal that a verb takes where nobody names one."""

from __future__ import annotations

import argparse
from pathlib import Path

import pytest

from bt_orchestrator.cli.here import add_cell_option, add_journal_option


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def parsed(*words: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    add_cell_option(parser)
    add_journal_option(parser)
    return parser.parse_args(words)


def files(folder: Path, *names: str) -> None:
    for name in names:
        (folder / name).touch()


def test_files_of_folder_are_used_and_named(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files(folder, 'cell.yaml', 'line.db', 'line.db-mark', 'line.db-wal', 'notes.db')
    options = parsed()
    assert (options.cell, options.journal) == (Path('cell.yaml'), Path('line.db'))
    assert capsys.readouterr().err == 'cell file: cell.yaml\njournal: line.db\n'


def test_a_named_file_is_taken_without_a_word(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files(folder, 'cell.yaml', 'line.db', 'line.db-mark')
    options = parsed('--cell', 'other.yaml', '--journal', 'other.db')
    assert (options.cell, options.journal) == (Path('other.yaml'), Path('other.db'))
    assert capsys.readouterr().err == ''


@pytest.mark.parametrize(
    ('there', 'message'),
    [
        (['line.db', 'line.db-mark'], 'argument --cell: expected a cell file; there is no cell'),
        (['cell.yaml'], 'found none; name it: --journal FILE'),
        (['cell.yaml', 'gone.db-mark'], 'found none; name it: --journal FILE'),
        (['cell.yaml', 'b.db', 'b.db-mark', 'a.db', 'a.db-mark'], 'found a.db, b.db; name it'),
    ],
)
def test_a_folder_without_one_file_is_wrong_use(
    folder: Path, capsys: pytest.CaptureFixture[str], there: list[str], message: str
) -> None:
    files(folder, *there)
    with pytest.raises(SystemExit) as left:
        parsed()
    assert left.value.code == 2
    assert message in capsys.readouterr().err
