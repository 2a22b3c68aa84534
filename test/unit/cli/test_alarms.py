"""The verb `alarms`, on a journal file."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from fakes.hand_made_shift import the_day

from bt_orchestrator.cli.main import main
from bt_orchestrator.store.sqlite.store import SqliteStore


@pytest.fixture
def journal(tmp_path: Path) -> Path:
    """A journal of one shift."""
    store = SqliteStore(tmp_path / 'cell.db')
    store.append(the_day().events)
    store.close()
    return tmp_path / 'cell.db'


def alarms(journal: Path, capsys: pytest.CaptureFixture[str], *words: str) -> list[str]:
    assert main(('alarms', '--journal', str(journal), *words)) == 0
    return capsys.readouterr().out.splitlines()


def test_all_alarms_the_last_first(journal: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lines = alarms(journal, capsys)
    assert 'hold: restarted (1 job)' in lines[0]
    assert '  retry by ann 2026-05-18 07:20:00: cleared the jam' in lines
    assert '  ann: called the fitter' in lines


@pytest.mark.parametrize(
    ('words', 'keys'),
    [
        ((), ['1', '2', 'abort', '9', '3']),
        (('--component', 'a2'), ['1', '9']),
        (('--kind', 'emergency', '--kind', 'contest'), ['abort']),
        (('--from', '2026-05-18T12:05Z'), ['3']),
        (('--to', '2026-05-18T12:05Z', '--job', 'J'), ['1', '9']),
        (('--open',), []),
    ],
)
def test_what_is_chosen(
    journal: Path, capsys: pytest.CaptureFixture[str], words: tuple[str, ...], keys: list[str]
) -> None:
    lines = alarms(journal, capsys, '--json', *words)
    assert [json.loads(line)['key'] for line in lines] == keys


def test_counts_a_table_and_nothing(
    journal: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    counted = alarms(journal, capsys, '--count', '--component', 'a2')
    assert counted[1].split() == ['hold,', 'a2,', 'aborted', '1', '0:20:00']
    assert alarms(journal, capsys, '--open') == ['no alarms']
    assert alarms(journal, capsys, '--csv', '-o', str(tmp_path / 'a.csv')) == []
    assert len((tmp_path / 'a.csv').read_text().splitlines()) == 6
