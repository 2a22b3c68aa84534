"""A row that is not as it was written is noticed by whoever reads it, and the rest is read."""

from __future__ import annotations

import json
import shutil
import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest
from fakes.journal_reading import journal_reading
from fakes.long_journal import LongRun

from bt_orchestrator.base.errors import DamagedRecord, JournalFailed, JournalUnusable
from bt_orchestrator.cli.main import main
from bt_orchestrator.model.events import Event, JobStarted
from bt_orchestrator.model.keeping.records import Wanted
from bt_orchestrator.store.sqlite.store import SqliteStore


def events(first: int, last: int) -> list[Event]:
    return [JobStarted(seq=n, time=n / 2, job=f'WO-{n}') for n in range(first, last + 1)]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / 'journal.sqlite3'
    store = SqliteStore(path)
    for n in range(1, 21):
        store.append(events(n, n))
    store.close()
    return path


def change(path: Path, statement: str) -> None:
    database = sqlite3.connect(path)
    database.execute(statement)
    database.commit()
    database.close()


DAMAGE: dict[str, tuple[str, str]] = {
    'one letter': (
        "UPDATE events SET record = replace(record, 'WO-7', 'WO-6') WHERE seq = 7",
        '7',
    ),
    'no JSON': ("UPDATE events SET record = replace(record, '{', '[') WHERE seq = 7", '7'),
    'no UTF-8': ("UPDATE events SET record = CAST(x'7bff7d' AS TEXT) WHERE seq = 7", '7'),
    'check': ('UPDATE events SET checksum = checksum + 1 WHERE seq = 7', '7'),
    'end of a commit': ('UPDATE events SET ends = 0 WHERE seq = 7', '7'),
    'no check': ('UPDATE events SET checksum = NULL WHERE seq = 7', '7'),
    'another number': ('UPDATE events SET seq = 70 WHERE seq = 20', '20'),
    'gone': ('DELETE FROM events WHERE seq = 7', '7'),
}
EVERY = pytest.mark.parametrize(
    'statement', [statement for statement, _ in DAMAGE.values()], ids=DAMAGE
)


@EVERY
def test_a_store_reads_up_to_it(path: Path, statement: str) -> None:
    change(path, statement)
    bad = 20 if 'seq = 70' in statement else 7
    store = SqliteStore(path)
    read: list[Event] = []
    with pytest.raises(DamagedRecord, match=f'events? {bad}'):
        read.extend(store.read())
    assert read == events(1, bad - 1)
    assert list(store.read(7)) == events(8, 20) if bad == 7 else True
    assert f'a record after event {bad - 1} is damaged, or it is not there' in store.missing(
        bad - 1
    )
    store.close()


def test_damaged_commit_is_not_read_at_all(path: Path) -> None:
    store = SqliteStore(path)
    store.append(events(21, 24))
    store.append(events(25, 25))
    store.close()
    change(path, "UPDATE events SET record = '' WHERE seq = 23")
    store = SqliteStore(path)
    read: list[Event] = []
    with pytest.raises(DamagedRecord, match='event 23'):
        read.extend(store.read())
    assert read == events(1, 20)
    assert list(store.read(23)) == events(24, 25)
    assert list(store.read(10, 12)) == events(11, 22)  # all that was asked for
    store.close()


@EVERY
def test_what_is_after_it_is_kept_aside(path: Path, statement: str) -> None:
    change(path, statement)
    before = path.read_bytes()
    bad = 20 if 'seq = 70' in statement else 7
    store = SqliteStore(path)
    store.go_on_after(bad - 1)
    assert list(store.read()) == events(1, bad - 1)
    store.append(events(bad, bad + 2))
    assert list(store.read()) == events(1, bad + 2)
    store.close()
    (aside,) = path.parent.glob('*.damaged-*Z')
    assert aside.read_bytes() == before
    assert aside.stat().st_mode & 0o777 == 0o600
    again = SqliteStore(path)
    assert again.missing(bad + 2) == ''
    again.close()


def test_nothing_is_written_if_it_cannot_be_kept(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise OSError(28, 'No space left on device')

    change(path, DAMAGE['gone'][0])
    before = path.read_bytes()
    store = SqliteStore(path)
    store.go_on_after(6)
    monkeypatch.setattr(shutil, 'copyfileobj', full)
    with pytest.raises(JournalFailed, match=r'cannot be kept as .*No space left'):
        store.append(events(7, 7))
    assert path.read_bytes() == before
    store.close()


@EVERY
@pytest.mark.parametrize(
    'wanted',
    [Wanted(), Wanted(job='WO-8'), Wanted(events=('job.',)), Wanted(since=1.0), Wanted(until=9.0)],
    ids=['all', 'job', 'event', 'since', 'until'],
)
def test_a_reader_tells_it_and_shows_the_rest(path: Path, statement: str, wanted: Wanted) -> None:
    with journal_reading(path) as reader:
        whole = dict(reader.each(wanted))
    change(path, statement)
    messages: list[str] = []
    with journal_reading(path, messages.append) as reader:
        records = dict(reader.each(wanted))
        assert records.items() <= whole.items()
        assert len(whole.keys() - records.keys()) <= 1
        assert bool(messages) == bool(reader.lost)
        assert len(messages) <= 2
    assert any('in the journal' in words for words in messages)


def test_every_filter_reads_what_it_read_before(tmp_path: Path) -> None:
    run = LongRun(tmp_path / 'journal.sqlite3')
    run.job('J1')
    run.job('J2')
    run.close()
    with journal_reading(tmp_path / 'journal.sqlite3') as reader:
        records = [json.loads(text) for _, text in reader.each(Wanted())]
        of_job = [seq for seq, _ in reader.each(Wanted(job='J2', events=('task.',)))]
    assert of_job == [
        r['seq'] for r in records if r.get('job') == 'J2' and r['event'].startswith('task.')
    ]


Verb = Callable[[Path], list[str]]


@pytest.mark.parametrize('form', ['text', 'jsonl', 'csv', 'xes'])
def test_the_verbs_say_it_and_end_with_1(
    tmp_path: Path, form: str, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / 'journal.sqlite3'
    run = LongRun(path)
    run.job('J1')
    run.close()
    change(
        path, 'UPDATE events SET record = replace(record, \'"J1/1"\', \'"J1/9"\') WHERE seq > 4'
    )
    change(path, "UPDATE jobs SET summary = replace(summary, 'completed', 'aborted')")
    for words in (['events', '--format', form], ['history', '--items']):
        assert main([*words, '--journal', str(path)]) == 1
        shown = capsys.readouterr()
        assert 'in the journal' in shown.err
        assert 'J1/9' not in shown.out
        assert 'J1' in shown.out


def test_the_name_of_a_history_is_checked_too(path: Path) -> None:
    change(path, "UPDATE history SET id = replace(id, substr(id, 5, 1), 'x')")
    with pytest.raises(JournalUnusable, match='the row of the table history is damaged'):
        SqliteStore(path)


def test_retention_removes_a_damaged_record_like_any(path: Path) -> None:
    change(path, "UPDATE events SET record = 'no JSON' WHERE seq = 7")
    store = SqliteStore(path)
    store.append(events(21, 21))
    database = store._database
    database.execute("INSERT INTO beginning VALUES (1, 15, '', '', '')")
    assert store.remove_batch(12) is False
    assert store.first_seq() == 12
    store.close()


def test_first_events_are_missed_unless_retention_removed_them(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    change(path, 'DELETE FROM events WHERE seq < 5')
    with closing(SqliteStore(path)) as store, pytest.raises(DamagedRecord, match='events 1 to 4'):
        list(store.read())
    assert main(['events', '--journal', str(path)]) == 1
    assert 'events 1 to 4 are not there' in capsys.readouterr().err

    with closing(SqliteStore(path)) as store:
        store.append(events(21, 21))
        store._database.execute("INSERT INTO beginning VALUES (1, 15, '', '', '')")
        assert store.remove_batch(12) is False
        assert list(store.read()) == events(12, 21)
    assert main(['events', '--journal', str(path)]) == 0
    assert capsys.readouterr().err == ''
