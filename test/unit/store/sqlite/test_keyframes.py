"""Some states of the past stay in the journal, for whoever wants a moment of then."""

from __future__ import annotations

from pathlib import Path

import pytest

from bt_orchestrator.model.events import Event, JobStarted
from bt_orchestrator.ports import Snapshot
from bt_orchestrator.store.shared import snapshots
from bt_orchestrator.store.sqlite.store import SqliteStore


def events(first: int, last: int) -> list[Event]:
    return [JobStarted(seq=n, time=n / 2, job=f'WO-{n}') for n in range(first, last + 1)]


def kept(store: SqliteStore) -> list[int]:
    rows = store._database.execute('SELECT seq FROM snapshots ORDER BY seq').fetchall()
    return [seq for (seq,) in rows]


def test_one_in_a_thousand_events_stays(tmp_path: Path) -> None:
    store = SqliteStore(tmp_path / 'journal.sqlite3')
    for seq in range(100, 5001, 100):
        store.append(events(seq - 99, seq))
        store.save(Snapshot(seq, 'program', '{}'))
    assert kept(store) == [100, 1100, 2100, 3100, 4100, 4900, 5000]
    assert [snapshot.seq for snapshot in store.snapshots()] == [5000, 4900]  # for a start, as ever
    store.close()


def test_a_large_state_stays_seldom(tmp_path: Path) -> None:
    store = SqliteStore(tmp_path / 'journal.sqlite3')
    large = '{"x": "' + 50_000 * 'x' + '"}'
    for seq in range(500, 10_001, 500):
        store.append(events(seq - 499, seq))
        store.save(Snapshot(seq, 'program', large))
    assert kept(store) == [500, 3500, 6500, 9500, 10_000]
    store.close()


def test_the_nearest_sound_one_is_given(tmp_path: Path) -> None:
    store = SqliteStore(tmp_path / 'journal.sqlite3')
    for seq in range(1000, 5001, 1000):
        store.append(events(seq - 999, seq))
        store.save(Snapshot(seq, 'program', f'{{"at": {seq}}}'))
    database = store._database
    for seq, expected in ((999, None), (1000, 1000), (3999, 3000), (9999, 5000)):
        frame = snapshots.state_before(database, seq)
        assert (frame and frame.seq) == expected
    database.execute("UPDATE snapshots SET state = '{}' WHERE seq = 3000")
    frame = snapshots.state_before(database, 3999)
    assert frame is not None
    assert frame.state == '{"at": 2000}'
    store.close()


@pytest.mark.parametrize('before', [1500, 2001])
def test_they_go_with_the_events_that_retention_removes(tmp_path: Path, before: int) -> None:
    store = SqliteStore(tmp_path / 'journal.sqlite3')
    for seq in range(1000, 6001, 1000):
        store.append(events(seq - 999, seq))
        store.save(Snapshot(seq, 'program', '{}'))
    store.begin_with(Snapshot(6000, 'program', '{}'))
    while store.remove_batch(before):
        pass
    assert kept(store)[0] == 2000
    store.close()
