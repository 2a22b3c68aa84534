"""The verb `report`, on a journal file."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import pytest
from fakes.day import at
from fakes.hand_made_shift import LINE, SHIFTS, the_day

from bt_orchestrator.cli.main import main
from bt_orchestrator.cli.reporting import following
from bt_orchestrator.cli.reporting.following import StopOrKey
from bt_orchestrator.store.sqlite.store import SqliteStore


@pytest.fixture(scope='module')
def journal(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A journal of one shift, with a file of shifts and a cell file beside it."""
    folder = tmp_path_factory.mktemp('journal')
    store = SqliteStore(folder / 'cell.db')
    store.append(the_day().events)
    store.close()
    (folder / 'shifts.yaml').write_text(SHIFTS)
    (folder / 'cell.yaml').write_text(LINE.text)
    return folder / 'cell.db'


def report(journal: Path, *words: str) -> int:
    return main(('report', '--journal', str(journal), *words))


def of_shift(journal: Path, name: str = 'early', day: str = '2026-05-18') -> tuple[str, ...]:
    return '--shifts', str(journal.parent / 'shifts.yaml'), '--shift', name, '--day', day


def plain(journal: Path, capsys: pytest.CaptureFixture[str], *words: str) -> dict[str, object]:
    assert report(journal, '--json', *words) == 0
    data: dict[str, object] = json.loads(capsys.readouterr().out)
    return data


def test_a_shift_as_text(journal: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert report(journal, *of_shift(journal), '--cell', str(journal.parent / 'cell.yaml')) == 0
    text = capsys.readouterr().out
    lines = text.splitlines()
    assert lines[0] == (
        'cell test_line, shift early of 2026-05-18, 2026-05-18 06:00:00 to 2026-05-18 14:00:00'
    )
    assert lines[1].startswith('  made from events 2 to ')
    assert lines[2] == '  the pace is by a cell file that is not the one that the node ran with'
    assert '  - own fault                0:22:00       4.9 %' in lines
    assert '      waiting for an answer  0:02:00       0.4 %' in lines
    assert '  07:00:00 to 07:20:00, 0:20:00 lost  section 2, work (TASK_A) of J/1 at a2' in text
    assert '    retry by ann: cleared the jam' in lines


def test_report_without_cell_file_omits_only_oee(
    journal: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    data = plain(journal, capsys, *of_shift(journal))
    assert data['oee'] == {
        'availability': 0.813561, 'performance': None, 'quality': 0.965251, 'oee': None,
    }  # fmt: skip
    note = 'no performance and no OEE: for the pace of test the cell file is needed: --cell CELL'
    assert note in data['notes']  # type: ignore[operator]
    assert data['waterfall'][-1]['title'] == 'actual production time'  # type: ignore[index]


def test_other_periods(journal: Path, capsys: pytest.CaptureFixture[str]) -> None:
    whole = plain(journal, capsys)['period']
    job = plain(journal, capsys, '--job', 'J')['period']
    assert (whole['planned_s'], job['planned_s']) == (29700.0, 28200.0)  # type: ignore[index]
    part = plain(journal, capsys, '--from', '2026-05-18T07:00Z', '--to', '2026-05-18T07:30Z')
    assert part['losses'] == {'own_fault': 1200.0, 'rework': 300.0, 'slow': 300.0}
    shifts = ('--shifts', str(journal.parent / 'shifts.yaml'))
    day = plain(journal, capsys, '--day', '2026-05-18', *shifts)['period']
    assert day['planned_s'] == 27000.0  # type: ignore[index]


def test_a_table_in_a_file(journal: Path, tmp_path: Path) -> None:
    out = tmp_path / 'shift.csv'
    assert report(journal, *of_shift(journal), '--csv', '-o', str(out)) == 0
    with out.open(encoding='utf-8', newline='') as file:
        rows = list(csv.DictReader(file))
    lost = {row['name']: float(row['seconds']) for row in rows if row['part'] == 'loss'}
    assert lost['own_fault'] == 1320.0
    assert {row['part'] for row in rows} >= {'period', 'oee', 'job', 'stop', 'hold', 'component'}


@pytest.fixture
def of_days(journal: Path) -> tuple[str, ...]:
    """Options for the two days to the one of the journal, which is the second."""
    folder = journal.parent
    files = ('--shifts', str(folder / 'shifts.yaml'), '--cell', str(folder / 'cell.yaml'))
    return '--days', '2', '--day', '2026-05-18', *files


def test_days_and_shifts_side_by_side(
    journal: Path, capsys: pytest.CaptureFixture[str], of_days: tuple[str, ...]
) -> None:
    assert report(journal, *of_days) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith('cell test_line, 2026-05-17 to 2026-05-18, 2026-05-17 00:00:00 to ')
    (lost,) = (line.split()[3:] for line in lines if line.startswith('- own fault'))
    assert lost == ['-', '0:22:00', '0:22:00']
    early = plain(journal, capsys, *of_days, '--shift', 'early')
    each = plain(journal, capsys, *of_days, '--each-shift')
    assert early == each
    assert [entry['title'] for entry in each['columns']] == ['early 05-17', 'early 05-18']  # type: ignore[attr-defined]
    alone = plain(journal, capsys, *of_shift(journal), *of_days[-2:])
    rows = {entry['name']: entry for entry in each['groups'][0]['rows']}  # type: ignore[index]
    assert rows['own_fault']['values'] == [None, alone['losses']['own_fault']]  # type: ignore[index]
    assert rows['oee']['values'] == [None, alone['oee']['oee']]  # type: ignore[index]


def test_side_by_side_report_as_table_and_page(
    journal: Path, tmp_path: Path, of_days: tuple[str, ...]
) -> None:
    out = tmp_path / 'days.csv'
    assert report(journal, *of_days, '--csv', '-o', str(out)) == 0
    with out.open(encoding='utf-8', newline='') as file:
        values = {(row['column'], row['figure']): row['value'] for row in csv.DictReader(file)}
    assert (values['Mon 05-18', 'good'], values['Sun 05-17', 'good']) == ('500', '')
    assert values['together', 'own_fault'] == '1320.0'
    page = tmp_path / 'days.html'
    assert report(journal, *of_days, '--html', '-o', str(page)) == 0
    assert '<b>cleared the jam' not in page.read_text(encoding='utf-8')
    assert 'retry by ann: cleared the jam' in page.read_text(encoding='utf-8')


@pytest.mark.parametrize(
    ('by', 'line'),
    [
        ('product', 'test       518   500              6        10        2            96.5 %'),
        ('job', 'J       518   500              6        10        2            96.5 %'),
        (
            'component',
            'a2    0:20:00      1            0           1         6:09:58         1  6:09:58',
        ),
    ],
)
def test_by_what_was_made_and_what_failed(
    journal: Path, capsys: pytest.CaptureFixture[str], by: str, line: str
) -> None:
    assert report(journal, *of_shift(journal), '--by', by) == 0
    assert line in capsys.readouterr().out
    assert report(journal, *of_shift(journal), '--by', by, '--html') == 0
    assert f'By {by}' in capsys.readouterr().out


@pytest.fixture
def journal_at(
    journal: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Callable[[str], Path]:
    """Give a function that returns the journal of a time, at which `--follow` looks once."""
    monkeypatch.setattr(StopOrKey, 'ends_within', lambda *_: True)

    def grown(clock: str) -> Path:
        monkeypatch.setattr(following, 'time', SimpleNamespace(time=lambda: at(clock)))
        store = SqliteStore(tmp_path / f'at {clock}.db')
        store.append([event for event in the_day().events if event.time <= at(clock)])
        store.close()
        return tmp_path / f'at {clock}.db'

    return grown


def test_the_shift_that_runs_is_followed(
    journal: Path, capsys: pytest.CaptureFixture[str], journal_at: Callable[[str], Path]
) -> None:
    shifts = ('--follow', '--shifts', str(journal.parent / 'shifts.yaml'))
    cell = ('--cell', str(journal.parent / 'cell.yaml'))
    data = plain(journal_at('13:11'), capsys, *shifts, *cell)
    assert data['runs']
    assert data['ends'] == '2026-05-18T14:00:00+00:00'
    assert data['stopped']['hold'] == '3'  # type: ignore[index]
    assert report(journal_at('07:10'), *shifts, *cell) == 0
    (line,) = capsys.readouterr().out.splitlines()
    text = '07:10:00  shift early of 2026-05-18: OEE 33.3 % = 66.7 % x 50.0 % x 100.0 %, made 400'
    assert line.startswith(text)
    assert line.endswith('own fault, a2, TASK_A aborted since 07:00:00')
    late = journal_at('15:00')
    data = plain(late, capsys, *shifts, *cell)
    ended = plain(late, capsys, *of_shift(journal), *cell)
    assert {name: data[name] for name in ended} == ended
    assert data['next'] == {'shift': 'early', 'begins': '2026-05-19T06:00:00+00:00'}
    assert report(late, *shifts) == 0
    assert 'it is over; early begins 2026-05-19 06:00:00' in capsys.readouterr().out


def test_a_day_and_a_time_are_followed(
    capsys: pytest.CaptureFixture[str], journal_at: Callable[[str], Path]
) -> None:
    noon = journal_at('12:05')
    since = plain(noon, capsys, '--follow', '--from', '2026-05-18T10:00Z')
    assert since['period']['planned_s'] == 7500.0  # type: ignore[index]
    assert since['losses']['emergency'] == 300.0  # type: ignore[index]
    assert (since['next'], since['ends']) == (None, None)
    day = plain(noon, capsys, '--follow')['period']
    assert day['name'] == '2026-05-18'  # type: ignore[index]


MISTAKES = {
    ('--follow', '--csv'): '--follow shows what goes on until now; leave --csv out',
    ('--follow', '--to', '2026-05-18'): '--follow shows what goes on until now; leave --to out',
    ('--follow', '--shifts', 'x', '--from', '2026-05-18'): (
        '--follow shows the shift that runs; leave --from out, or --shifts'
    ),
    ('--from', '2026-05-18T14:00Z', '--to', '2026-05-18T06:00Z'): (
        '--from has to be before --to; exchange them'
    ),
    ('--job', 'J', '--day', '2026-05-18'): (
        '--job and --shift or --day name a period each; leave one of them out'
    ),
    ('--shift', 'early'): '--shift needs the file in which the shifts are: --shifts FILE',
    (
        '--shifts',
        'none.yaml',
        '--day',
        '2026-05-18',
    ): 'none.yaml:1:1: the file does not exist; check the path',
    ('--job', 'K'): 'knows no start of job K; history --job K shows what it has',
    ('--day', '2026-05-10'): 'the journal has no event of 2026-05-10',
    ('--from', '2026-05-20T12:00Z'): 'the journal has no event of period (from 2026-05-2',
    ('--days', '7', '--job', 'J'): '--days and --job name a period each; leave one of them out',
    (
        '--days',
        '1',
    ): "expected a number of days from 2 to 92, found '1'; for one day there is --day",
    ('--each-shift',): '--each-shift says what the columns are: --days N says of how many days',
    ('--days', '7', '--each-shift'): (
        '--each-shift needs the file in which the shifts are: --shifts FILE'
    ),
    (
        '--days',
        '7',
        '--durations',
        '--cell',
        'x',
    ): '--durations goes over one period: leave --days',
    ('--follow', '--days', '7'): '--follow shows what goes on until now; leave --days out',
    ('--day', '18.5.2026'): "'18.5.2026' is not a day; write 2026-05-17",
}


@pytest.mark.parametrize(('words', 'what'), MISTAKES.items())
def test_a_mistake_of_a_user_is_a_sentence(
    journal: Path, capsys: pytest.CaptureFixture[str], words: tuple[str, ...], what: str
) -> None:
    try:
        status = report(journal, *words)
    except SystemExit as ended:
        status = int(str(ended.code))
    assert status in (1, 2)
    assert what in capsys.readouterr().err


@pytest.mark.parametrize(
    ('name', 'day', 'what'),
    [
        ('erly', '2026-05-18', 'shifts.yaml has no shift erly; did you mean `early`?'),
        ('early', '2100-01-04', 'shift early of 2100-01-04 has not begun yet'),
    ],
)
def test_a_shift_that_is_none(
    journal: Path, capsys: pytest.CaptureFixture[str], name: str, day: str, what: str
) -> None:
    assert report(journal, *of_shift(journal, name, day)) == 1
    assert what in capsys.readouterr().err
