"""A backup becomes the journal: all of it or nothing, and nothing that was there is lost."""

from __future__ import annotations

import shutil
import sqlite3
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
from fakes.journal_reading import journal_reading

from bt_orchestrator.base.errors import JournalUnusable
from bt_orchestrator.cli.main import main
from bt_orchestrator.model.events import Event, JobStarted
from bt_orchestrator.model.keeping.records import Wanted
from bt_orchestrator.store.sqlite import restoring
from bt_orchestrator.store.sqlite.keeping import sync
from bt_orchestrator.store.sqlite.restoring import bring_back
from bt_orchestrator.store.sqlite.schema import SCHEMA
from bt_orchestrator.store.sqlite.store import SqliteStore

DATA = Path(__file__).parents[3] / 'data'


def events(last: int) -> list[Event]:
    return [JobStarted(seq=n, time=n / 2, job=f'WO-{n}') for n in range(1, last + 1)]


def write(path: Path, last: int) -> Path:
    store = SqliteStore(path)
    store.append(events(last))
    store.close()
    return path


def killed(path: Path, last: int) -> Path:
    """Leave a journal whose events are in its log."""
    written = path.with_name('written')
    for ending in ('', '-mark'):
        written.with_name(written.name + ending).unlink(missing_ok=True)
    store = SqliteStore(written)
    store.append(events(last))
    for ending in ('', '-wal', '-shm', '-mark'):
        shutil.copy(written.with_name(written.name + ending), path.with_name(path.name + ending))
    store.close()
    return path


def last_seq(path: Path) -> int:
    """Return the last event that the next node finds."""
    store = SqliteStore(path)
    try:
        return max(event.seq for event in store.read())
    finally:
        store.close()


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    return write(tmp_path / 'copy.sqlite3', 10)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / 'line' / 'journal.sqlite3'


@pytest.fixture
def there(path: Path) -> Path:
    """Give a journal that is there already; its node was killed."""
    path.parent.mkdir()
    return killed(path, 30)


def files(folder: Path) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in folder.iterdir() if file.suffix != '.lock'}


def refusal(copy: Path, path: Path) -> str:
    before = files(path.parent) if path.parent.exists() else {}
    with pytest.raises(JournalUnusable) as refused:
        bring_back(copy, path, move_aside=True)
    assert files(path.parent) == before
    return str(refused.value)


def test_a_copy_becomes_a_history_of_its_own(copy: Path, path: Path) -> None:
    before = copy.read_bytes()
    done = bring_back(copy, path)
    assert (done.last_seq, done.aside) == (10, None)
    assert copy.read_bytes() == before
    store = SqliteStore(path)
    assert list(store.read()) == events(10)
    assert store.is_restored
    again = SqliteStore(copy)
    assert not again.is_restored
    assert done.history == store.history != again.history
    store.close()
    again.close()


def test_log_of_a_copy_is_restored_too(tmp_path: Path, path: Path) -> None:
    copy = killed(tmp_path / 'copy.sqlite3', 30)
    copy.with_name('copy.sqlite3-shm').unlink()
    assert bring_back(copy, path).last_seq == last_seq(path) == 30


@pytest.mark.parametrize(('name', 'last'), [('journal_schema_1.sqlite3', 156), ('killed', 184)])
def test_a_copy_of_an_older_program(tmp_path: Path, path: Path, name: str, last: int) -> None:
    shutil.unpack_archive(DATA / 'journals_schema_2' / 'journals.tar.gz', tmp_path)
    copy = tmp_path / 'killed' / 'journal.sqlite3' if name == 'killed' else DATA / name
    assert bring_back(copy, path).last_seq == last
    database = sqlite3.connect(path)
    assert database.execute('PRAGMA user_version').fetchone() == (SCHEMA,)
    database.close()
    with journal_reading(path) as reader:
        assert [seq for seq, _ in reader.each(Wanted())] == list(range(1, last + 1))


def test_existing_journal_is_kept_under_another_name(copy: Path, there: Path) -> None:
    before = files(there.parent)
    with pytest.raises(JournalUnusable, match='with --move-aside it is kept'):
        bring_back(copy, there)
    assert files(there.parent) == before
    aside = bring_back(copy, there, move_aside=True).aside
    assert aside is not None
    assert last_seq(there) == 10
    for name, content in before.items():
        if not name.startswith('written'):
            ending = name.removeprefix(there.name)
            assert aside.with_name(aside.name + ending).read_bytes() == content
    assert last_seq(aside) == 30


@pytest.mark.parametrize('parts', [('',), ('-wal',), ('', '-wal', '-shm')])
def test_remains_of_a_journal_are_not_replaced_silently(
    copy: Path, path: Path, parts: Sequence[str]
) -> None:
    killed(path, 30)
    for ending in {'', '-wal', '-shm'} - set(parts):
        path.with_name(path.name + ending).unlink()
    before = sorted(path.parent.iterdir())
    with pytest.raises(JournalUnusable, match='with --move-aside it is kept'):
        bring_back(copy, path)
    assert set(before) <= set(path.parent.iterdir())
    assert not list(path.parent.glob('*.aside-*'))


def test_a_journal_in_use_is_left_alone(copy: Path, path: Path) -> None:
    store = SqliteStore(path)
    store.append(events(3))
    with pytest.raises(JournalUnusable, match='in use by another orchestrator'):
        bring_back(copy, path, move_aside=True)
    store.append([JobStarted(seq=4, time=2.0, job='WO-4')])
    store.close()
    assert last_seq(path) == 4


def test_a_journal_in_use_is_no_copy(copy: Path, path: Path) -> None:
    store = SqliteStore(copy)
    with pytest.raises(JournalUnusable, match=r'copy\.sqlite3 is in use by another orchestrator'):
        bring_back(copy, path)
    store.close()
    assert bring_back(copy, path).last_seq == 10


def test_what_is_no_good_copy_is_refused(copy: Path, there: Path, tmp_path: Path) -> None:
    assert 'there is no copy' in refusal(tmp_path / 'none', there)
    assert 'is the journal itself' in refusal(there, there)
    (tmp_path / 'text').write_text('not a database at all' * 100)
    assert 'file is not a database' in refusal(tmp_path / 'text', there)
    (tmp_path / 'empty').touch()
    assert 'is empty' in refusal(tmp_path / 'empty', there)
    database = sqlite3.connect(copy)
    database.execute(f'PRAGMA user_version = {SCHEMA + 1}')
    database.close()
    assert f'has schema {SCHEMA + 1}' in refusal(copy, there)


def test_a_damaged_copy_is_refused(copy: Path, there: Path) -> None:
    whole = bytearray(copy.read_bytes())
    whole[2 * 4096 :] = b'\x5a' * len(whole[2 * 4096 :])
    copy.write_bytes(whole)
    assert 'cannot be used' in refusal(copy, there)


class Killed(BaseException):
    """The process ends here."""


@pytest.fixture
def steps(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[int]]:
    """Kill the restore at a step that changes names, or makes them durable; 0 is the first."""
    left = [1000]

    def killing(what: Callable[..., Any]) -> Callable[..., Any]:
        def step(*args: Any) -> Any:
            left[0] -= 1
            if left[0] < 0:
                raise Killed
            return what(*args)

        return step

    with monkeypatch.context() as patch:
        patch.setattr(restoring, 'sync', killing(sync))
        patch.setattr(restoring, '_remove', killing(restoring._remove))
        patch.setattr(Path, 'rename', killing(Path.rename))
        yield left


def test_interrupted_restore_leaves_whole_journal_or_none(
    copy: Path, there: Path, steps: list[int]
) -> None:
    seen = []
    for step in range(100):
        for file in there.parent.glob('journal.sqlite3*'):
            file.unlink()
        killed(there, 30)
        steps[0] = step
        try:
            bring_back(copy, there, move_aside=True)
        except Killed:
            steps[0] = 1000
        else:
            break
        if there.exists():
            seen.append(last_seq(there))
        else:
            seen.append(0)
            with pytest.raises(JournalUnusable, match=r'journal\.sqlite3 is missing'):
                SqliteStore(there)
        bring_back(copy, there, move_aside=True)
        assert last_seq(there) == 10
        asides = {file.suffix.partition('Z')[2] for file in there.parent.glob('*.aside-*')}
        assert {'', '-mark'} <= asides
    assert seen == sorted(seen, key=[30, 0, 10].index)
    assert set(seen) == {30, 0, 10}


def test_the_verb_says_what_it_did(
    copy: Path, there: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ['journal', 'restore', str(copy), str(there)]
    assert main(words) == 1
    assert 'journal: error: there is a journal' in capsys.readouterr().err
    assert main([*words, '--move-aside']) == 0
    output = capsys.readouterr().out
    assert f'the journal that was there is {there}.aside-' in output
    assert f'{there} goes on after event 10 of {copy}, as history ' in output
