"""The verbs `history` and `events --journal`, on a journal that was written."""

from __future__ import annotations

import csv
import json
import shutil
import signal
import threading
import time
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path

import pytest

from bt_orchestrator.cli import events
from bt_orchestrator.cli.main import INTERRUPTED, main
from bt_orchestrator.model.events import JobStarted
from bt_orchestrator.store.sqlite.store import SqliteStore

SCHEMA_1 = Path(__file__).parents[2] / 'data' / 'journal_schema_1.sqlite3'
"""Two jobs that ended: J1 with an attempt that failed, J2."""


@pytest.fixture
def journal(tmp_path: Path) -> str:
    return str(shutil.copy(SCHEMA_1, tmp_path / 'journal.sqlite3'))


def said(capsys: pytest.CaptureFixture[str], *words: str, status: int = 0) -> str:
    assert main(words) == status
    captured = capsys.readouterr()
    return captured.err if status else captured.out


def seqs(output: str) -> list[int]:
    return [json.loads(line)['seq'] for line in output.splitlines()]


def test_history(journal: str, capsys: pytest.CaptureFixture[str]) -> None:
    lines = said(capsys, 'history', '--journal', journal).splitlines()
    first, second = (line.split() for line in lines[1:3])
    assert first[:3] == ['J1', 'test', 'completed']
    assert first[-6:] == ['3', '3', '0', '0', '0', '1']
    assert second[-6:] == ['2', '2', '0', '0', '0', '0']
    assert lines[3:] == ['J1: work failed (aborted)']


def test_history_of_items(journal: str, capsys: pytest.CaptureFixture[str]) -> None:
    text = said(capsys, 'history', '--journal', journal, '--job', 'J1', '--items')
    assert 'J2' not in text
    assert '  J1/2  packed  ' in text
    assert '    work failed: aborted' in text
    title, failed = text.splitlines()[3:5]
    assert (title, failed) == ('J1:', '  work failed (aborted)'), 'under its job'
    assert text.count('    pack: {"item_present": true, "measurement": 0.0}') == 3


def test_history_for_programs(journal: str, capsys: pytest.CaptureFixture[str]) -> None:
    words = ('history', '--journal', journal, '--json')
    (first, _) = map(json.loads, said(capsys, *words).splitlines())
    assert (first['job'], first['status'], first['counts']['packed']) == ('J1', 'completed', 3)
    assert 'items' not in first
    (only,) = map(json.loads, said(capsys, *words, '--items', '--job', 'J2').splitlines())
    assert list(only['items']) == ['J2/1', 'J2/2']


def test_history_of_a_script_in_an_old_journal(
    journal: str, capsys: pytest.CaptureFixture[str]
) -> None:
    text = said(capsys, 'history', '--journal', journal, '--job', 'J1', '--script')
    assert text.splitlines()[1] == 'script: test'
    assert '    - {id: work, task: ' in text


def test_history_as_job_responses(journal: str, capsys: pytest.CaptureFixture[str]) -> None:
    words = ('history', '--journal', journal, '--b2mml', '--job', 'J1')
    (line,) = said(capsys, *words).splitlines()
    response = json.loads(line)['JobResponse']
    assert (response['JobOrderID'], response['JobState']) == ('J1', 'Ended')
    values = {item['ID']: item['Value'][0]['ValueString'] for item in response['JobResponseData']}
    assert (values['GoodQuantity'], values['JobResult']) == ('3', '1')


def test_history_for_programs_without_a_job_is_nothing(
    journal: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert said(capsys, 'history', '--journal', journal, '--json', '--from', '2100-01-01') == ''


def test_history_by_time(journal: str, capsys: pytest.CaptureFixture[str]) -> None:
    since = ('--from', '1970-01-01T00:00:05+00:00')
    assert 'J1' not in said(capsys, 'history', '--journal', journal, *since)
    with pytest.raises(SystemExit, match='2'):
        main(['history', '--journal', journal, '--from', 'yesterday'])
    assert "'yesterday' is not a time; write 2026-05-17" in capsys.readouterr().err


def test_missing_job_or_journal_is_reported(
    journal: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(['history', '--journal', journal, '--job', 'J7']) == 1
    assert 'knows no job J7' in capsys.readouterr().err
    assert 'there is no journal none' in said(capsys, 'history', '--journal', 'none', status=1)


def test_events_with_filters(journal: str, capsys: pytest.CaptureFixture[str]) -> None:
    words = ('events', '--journal', journal)
    assert seqs(said(capsys, *words)) == list(range(1, 157))
    assert seqs(said(capsys, *words, '--since-seq', '150')) == list(range(151, 157))
    assert seqs(said(capsys, *words, '--count', '2', '--job', 'J2')) == [94, 99]
    ended = said(capsys, *words, '--event', 'job.completed', '--event', 'job.aborted')
    assert [json.loads(line)['job'] for line in ended.splitlines()] == ['J1', 'J2']
    late = said(capsys, *words, '--from', '1970-01-01T00:00:25+00:00', '--event', 'task.')
    assert [json.loads(line)['time'] for line in late.splitlines()] == [25.0]


def test_the_last_events(journal: str, capsys: pytest.CaptureFixture[str]) -> None:
    words = ('events', '--journal', journal, '--last')
    assert seqs(said(capsys, *words, '3')) == [154, 155, 156]
    assert seqs(said(capsys, *words, '900')) == list(range(1, 157))
    assert seqs(said(capsys, *words, '0')) == []
    assert seqs(said(capsys, *words, '2', '--job', 'J1', '--event', 'item.removed')) == [73, 87]
    assert 'leave one of them out' in said(capsys, *words, '3', '--since-seq', '1', status=2)


def test_events_in_other_formats(
    journal: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ('events', '--journal', journal)
    text = said(capsys, *words, '--format', 'text', '--event', 'task.failed')
    assert '#45 ' in text
    assert 'task.failed           section 2 J1/2 work attempt=1' in text
    table = tmp_path / 'events.csv'
    said(capsys, *words, '--format', 'csv', '-o', str(table))
    with table.open(newline='') as file:
        assert len(list(csv.DictReader(file))) == 156
    log = tmp_path / 'events.xes'
    said(capsys, *words, '--format', 'xes', '-o', str(log))
    assert len(ET.parse(log).findall('{http://www.xes-standard.org/}trace')) == 5


def test_what_makes_no_sense(journal: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert 'add --journal FILE' in said(capsys, 'events', '--job', 'J1', status=2)
    words = ('events', '--journal', journal, '--format', 'xes')
    assert 'leave --follow out' in said(capsys, *words, '--follow', status=2)
    nowhere = ('-o', '/none/there')
    assert 'cannot write /none/there: No such file' in said(capsys, *words, *nowhere, status=2)


def test_a_long_export_ends_at_ctrl_c(
    journal: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def endless(*_: object) -> Iterator[str]:
        signal.raise_signal(signal.SIGINT)
        deadline = time.monotonic() + 20.0
        while time.monotonic() < deadline:
            yield '{"seq": 1, "time": 0.0, "event": "x"}'

    monkeypatch.setattr(events, '_records', endless)
    words = ('events', '--journal', journal, '--format', 'csv', '-o', str(tmp_path / 'x.csv'))
    assert main(words) == INTERRUPTED


def test_what_comes_is_followed(journal: str, capsys: pytest.CaptureFixture[str]) -> None:
    words = ('events', '--journal', journal, '--follow', '--since-seq', '154', '--count', '3')
    later = threading.Timer(0.3, _append_from_elsewhere, (journal,))
    later.start()
    assert seqs(said(capsys, *words)) == [155, 156, 157]
    later.join()


def _append_from_elsewhere(journal: str) -> None:
    store = SqliteStore(Path(journal))
    store.append([JobStarted(seq=157, time=30.0, job='J3')])
    store.close()


def test_a_full_disk_is_told(journal: str, capsys: pytest.CaptureFixture[str]) -> None:
    output = said(capsys, 'events', '--journal', journal, '-o', '/dev/full', status=1)
    assert output == 'bt-orchestrator events: error: No space left on device\n'
