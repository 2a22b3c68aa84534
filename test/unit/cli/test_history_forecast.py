"""The option `--forecast` of the verb `history`: a job beside its forecast, of a journal file."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from fakes.action_types import FakeActionTypes
from fakes.line import THREE, Line
from fakes.virtual_run import VirtualRun

from bt_orchestrator.cli.main import main
from bt_orchestrator.model.goal import GoalRequest
from bt_orchestrator.store.sqlite.store import SqliteStore

LINE = Line(3)
SVG = '{http://www.w3.org/2000/svg}'


@pytest.fixture(scope='module')
def journal(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A journal of a job of three items, in which a2 took 3 s in place of 1 s; its cell file."""
    folder = tmp_path_factory.mktemp('journal')

    def really_s(request: GoalRequest) -> float:
        component = LINE.cell.components[request.component]
        return 3.0 if component.name == 'a2' else component.duration_s(request.task)

    run = VirtualRun(LINE.cell, FakeActionTypes(), duration=really_s)
    run.submit('WO-1', LINE.script(THREE), 3)
    run.submit('WO-2', LINE.script(THREE), 1)
    run.control('hold', 'WO-2')
    run.go()
    store = SqliteStore(folder / 'cell.db')
    store.append(run.store.read())
    store.close()
    (folder / 'cell.yaml').write_text(LINE.text)
    return folder / 'cell.db'


def compared(
    journal: Path, capsys: pytest.CaptureFixture[str], *words: str, status: int = 0
) -> str:
    cell = str(journal.parent / 'cell.yaml')
    given = ('history', '--journal', str(journal), '--forecast', '--cell', cell, *words)
    assert main(given) == status
    captured = capsys.readouterr()
    return captured.err if status else captured.out


def test_as_text(journal: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lines = compared(journal, capsys, '--job', 'WO-1').splitlines()
    assert lines[0].startswith('cell test_line, job WO-1, started 1970-01-01')
    assert lines[1].startswith('  the forecast is a virtual run from event ')
    assert '  a2 TASK_A      3         1.00 s     3.00 s      +6.0 s' in lines
    (first,) = [number for number, line in enumerate(lines) if line.startswith('first deviation')]
    assert lines[first + 1] == (
        '  section 2, work of WO-1/1 (TASK_A) at a2 ended 2.0 s late: it began in time and took '
        '3.0 s in place of 1.0 s'
    )


def test_as_data(journal: Path, capsys: pytest.CaptureFixture[str]) -> None:
    comparison = json.loads(compared(journal, capsys, '--job', 'WO-1', '--json'))
    assert comparison['late_s'] == 6.0
    assert comparison['items'] == [{'what': 'packed', 'forecast': 3, 'real': 3}]
    assert comparison['components'][0] == {'what': 'a2', 'forecast_s': 3.0, 'real_s': 9.0}
    assert comparison['worst_deviation']['item'] == 'WO-1/3'


def test_as_a_chart(journal: Path, capsys: pytest.CaptureFixture[str]) -> None:
    svg = ET.fromstring(compared(journal, capsys, '--job', 'WO-1', '--gantt'))
    row = next(group for group in svg.iter(f'{SVG}g') if group.get('id') == 'a2')
    kinds = [bar.get('class') for bar in row.iter(f'{SVG}rect')]
    assert (kinds.count('work forecast'), kinds.count('work')) == (3, 3)
    texts = [text.text for text in svg.iter(f'{SVG}text')]
    assert (texts[0] or '').startswith('job WO-1 from 1970-01-01 ')
    assert texts.count('forecast end') == texts.count('end') == 1
    assert 'forecast, above' in texts


@pytest.mark.parametrize(
    ('words', 'status', 'message'),
    [
        (('--job', 'WO-2'), 1, 'knows no start of job WO-2'),
        ((), 2, '--forecast compares one job, on its cell: --job JOB --cell CELL'),
        (('--job', 'WO-1', '--html'), 2, 'with --forecast go --json, --gantt and -o'),
    ],
)
def test_what_cannot_be_compared(
    journal: Path,
    capsys: pytest.CaptureFixture[str],
    words: tuple[str, ...],
    status: int,
    message: str,
) -> None:
    assert message in compared(journal, capsys, *words, status=status)


def test_a_cell_file_is_for_a_forecast(journal: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(['history', '--journal', str(journal), '--cell', 'cell.yaml']) == 2
    assert 'are for a forecast: add --forecast' in capsys.readouterr().err
