"""`status --at`: how a cell stood, from its journal, in words and as JSON."""

from __future__ import annotations

import json
from datetime import datetime, timezone
from pathlib import Path

import pytest
from fakes.shipped import REFERENCE_CELL, REFERENCE_ORDER, TREES

from bt_orchestrator.cli import bootstrap
from bt_orchestrator.cli.main import main
from bt_orchestrator.sim.simulation import Outcome, Simulation
from bt_orchestrator.store.sqlite.store import SqliteStore


@pytest.fixture(scope='module')
def journal(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp('past') / 'journal.sqlite3'
    types = bootstrap.installed_types()
    cell, given = bootstrap.load_jobs([REFERENCE_ORDER], REFERENCE_CELL, [TREES], types)
    store = SqliteStore(path, synchronous='NORMAL')
    simulation = Simulation(cell, types, store)
    bootstrap.queue(simulation, given)
    assert simulation.run() is Outcome.FINISHED
    simulation.close()
    store.close()
    return path


def said(
    capsys: pytest.CaptureFixture[str], journal: Path, at: str, *more: str, status: int = 0
) -> str:
    words = ('--at', at, '--journal', str(journal), '--cell', str(REFERENCE_CELL), *more)
    assert main(('status', *words)) == status
    captured = capsys.readouterr()
    return captured.err if status else captured.out


def test_a_past_moment_in_words(journal: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lines = said(capsys, journal, '60').splitlines()
    assert lines[0].startswith('PAST, at ')
    assert lines[0].endswith(', after event 60:')
    assert lines[1].startswith('cell reference_cell: Execute for ')
    assert lines[1].endswith('seq 60')
    assert any('waiting for' in line for line in lines)
    assert not any('bt-orchestrator' in line for line in lines), 'nothing can be done about it'


def test_past_status_accepts_time_and_prints_json(
    journal: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    by_number = json.loads(said(capsys, journal, '60', '--json'))
    assert (by_number['seq'], by_number['cell']) == (60, 'reference_cell')
    when = datetime.fromtimestamp(by_number['stamp'], timezone.utc).isoformat()
    by_time = json.loads(said(capsys, journal, when, '--json'))
    assert by_time['seq'] >= 60
    assert by_time['stamp'] == by_number['stamp']


def test_7_4_moment_between_events_tells_stop_cause(
    journal: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """All orders have ended, and the cell waits for the next one."""
    status = json.loads(said(capsys, journal, '2000-01-01', '--json'))
    assert status['stands']['cause'] == 'order'
    when = datetime.fromtimestamp(status['stamp'], timezone.utc)
    assert when.astimezone().isoformat().startswith('2000-01-01T00:00')
    words = said(capsys, journal, '2000-01-01').splitlines()
    assert words[0].endswith(f', after event {status["seq"]}, the last of the journal:')
    last = json.loads(said(capsys, journal, str(status['seq']), '--json'))
    assert last['stands'] == status['stands'], 'nothing has happened since'


@pytest.mark.parametrize(
    ('at', 'expected'),
    [
        ('99999', 'event 99999 is not in the journal: it has events 1 to'),
        ('1960-01-01', 'the journal has no event of 1960-01-01 '),
    ],
)
def test_a_moment_that_is_not_kept(
    journal: Path, capsys: pytest.CaptureFixture[str], at: str, expected: str
) -> None:
    assert expected in said(capsys, journal, at, status=1)


def test_what_is_missing_is_asked_for(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(('status', '--at', '60')) == 2
    assert 'name the journal and the cell' in capsys.readouterr().err
    assert main(('status', '--journal', 'x')) == 2
    assert '--journal and --cell are for --at' in capsys.readouterr().err
