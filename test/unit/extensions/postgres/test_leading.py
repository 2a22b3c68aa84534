"""Who leads a cell whose journal is in a database, and for how long (semantics 9.4)."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import closing, suppress
from pathlib import Path

import pytest
from contract.written_events import events
from postgres_faults import in_thread, wait_for, without_replica
from postgres_server import PostgresServer

from bt_orchestrator.base.errors import JournalAway, JournalFailed, JournalUnusable
from bt_orchestrator.extensions.postgres.connecting import Connection, connected, place_of
from bt_orchestrator.extensions.postgres.journal import PostgresStore, mark_place
from bt_orchestrator.extensions.postgres.leading import GUARD_S, IDLE_S, Looks
from bt_orchestrator.extensions.postgres.schema import FEED, enter
from bt_orchestrator.extensions.postgres.standing_by import PostgresStandby
from bt_orchestrator.model.uptime import ClockReading, Uptime
from bt_orchestrator.store.shared.mark import Mark


@pytest.fixture
def address(server: PostgresServer) -> str:
    return server.place(server.database(), 'line_1')


@pytest.fixture
def person(address: str) -> Iterator[Connection]:
    """Give the connection of somebody who looks on."""
    with connected(place_of(address), 'test', ['SET search_path = cell_1']) as session:
        yield session


def clocks() -> ClockReading:
    return ClockReading(time.time(), Uptime('this boot', time.monotonic()))


def cut(person: Connection, name: str = 'node') -> None:
    """End the sessions of a program, as a network does."""
    person.execute(
        'SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE application_name = %s',
        (f'bt_orchestrator {name}',),
    )


# --- the guard ----------------------------------------------------------------------------------


def test_9_4_command_right_ends_soon_after_last_write(address: str, tmp_path: Path) -> None:
    with closing(PostgresStore(address, tmp_path)) as store:
        began = time.monotonic()
        store.append(events(1, 2))
        wrote = time.monotonic()
        wait_for(lambda: not store.may_command())
        ended = time.monotonic()
        assert ended - began >= GUARD_S
        assert ended - wrote < GUARD_S + 0.5
        store.renew()
        assert store.may_command()
        assert list(store.read()) == events(1, 2), 'it writes no event'


def test_9_4_command_right_counts_from_begin_of_commit(
    address: str, person: Connection, tmp_path: Path
) -> None:
    with closing(PostgresStore(address, tmp_path)) as store:
        store.append(events(1, 2))
        wait_for(lambda: not store.may_command())
        with without_replica(person):
            began = time.monotonic()
            appended = in_thread(lambda: store.append(events(3, 4)))
            wait_for(lambda: time.monotonic() - began > 2.0)
            assert not store.may_command()
        appended()
        assert store.may_command()
        wait_for(lambda: not store.may_command())
        assert time.monotonic() - began < GUARD_S + 0.5


def test_9_4_a_database_that_cannot_commit_confirms_nobody(
    address: str, person: Connection, tmp_path: Path
) -> None:
    """As a primary does that others have replaced: it still answers who reads."""
    with closing(PostgresStore(address, tmp_path)) as store:
        store.append(events(1, 2))
        wait_for(lambda: not store.may_command())
        with without_replica(person):
            store.patience_s = 1.0
            with pytest.raises(JournalFailed):
                store.renew()
            assert not store.may_command()


def test_9_4_replaced_leader_notices_and_may_not_send(
    address: str, person: Connection, tmp_path: Path
) -> None:
    with closing(PostgresStore(address, tmp_path)) as store:
        store.append(events(1, 2))
        person.execute('UPDATE plant.cells SET epoch = epoch + 1')
        wait_for(lambda: not store.may_command())
        with pytest.raises(JournalFailed, match='another orchestrator has taken over'):
            store.renew()
        assert not store.may_command()


def test_9_4_silent_leader_loses_lock_and_fails_next_write(address: str, tmp_path: Path) -> None:
    with closing(PostgresStore(address, tmp_path)) as old:
        old.append(events(1, 2))
        began = time.monotonic()
        with closing(PostgresStandby(address, clocks, tmp_path / 'b')) as standby:
            standby.look()
            new = None
            while new is None:
                new = standby.take()
                assert time.monotonic() - began < IDLE_S + 5
            assert time.monotonic() - began > GUARD_S, 'it may have sent goals until then'
        with closing(new):
            assert not old.may_command()
            assert new.epoch == old.epoch + 1
            new.append(events(3, 4))
            began = time.monotonic()
            with pytest.raises(JournalFailed, match='another orchestrator has taken over'):
                old.append(events(3, 3))
            assert time.monotonic() - began < 2.0
            assert list(new.read()) == events(1, 4)


# --- the standby --------------------------------------------------------------------------------


def test_9_4_standby_waits_for_leader_and_takes_over(
    address: str, person: Connection, tmp_path: Path
) -> None:
    with closing(PostgresStandby(address, clocks, tmp_path / 'b')) as standby:
        with closing(PostgresStore(address, tmp_path / 'a')) as leader:
            leader.append(events(1, 5))
            seen = standby.look()
            assert (seen.history, seen.seq, seen.epoch) == (leader.history, 5, leader.epoch)
            assert seen.is_led
            assert 'process' in seen.leader
            assert standby.take() is None
            leader.append(events(6, 7))
        assert not standby.look().is_led
        new = standby.take()
        assert new is not None
    with closing(new):
        assert new.epoch == leader.epoch + 1
        assert list(new.read()) == events(1, 7)
        new.append(events(8, 9))


def test_9_4_standby_begins_cell_without_journal(address: str, tmp_path: Path) -> None:
    a, b = (PostgresStandby(address, clocks, tmp_path / name) for name in 'ab')
    with closing(a), closing(b):
        assert a.look().history == ''
        leader = a.take()
        assert leader is not None
        with closing(leader):
            leader.append(events(1, 2))
            assert b.take() is None
            assert b.look().seq == 2


def test_9_4_standby_records_what_it_saw_and_when(address: str, tmp_path: Path) -> None:
    with closing(PostgresStandby(address, clocks, tmp_path / 'b')) as standby:
        with closing(PostgresStore(address, tmp_path / 'a')) as leader:
            leader.append(events(1, 5))
            began = clocks()
            standby.look()
            looked = clocks()
            leader.append(events(6, 9))
            standby.look()
            leader.append(events(10, 10))
        new = standby.take()
        assert new is not None
    with closing(new):
        absent = new.absent_at(6)
        assert absent is not None
        assert began.up.seconds <= absent.up.seconds <= looked.up.seconds
        assert began.wall <= absent.wall <= looked.wall
        later = new.absent_at(10)
        assert later is not None
        assert later.up.seconds >= looked.up.seconds
        assert new.absent_at(5) is None, 'it was there from the first look on'


def test_9_4_a_look_that_no_replica_confirms_is_none(
    address: str, person: Connection, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As at a primary that was replaced: what it does not show may be elsewhere."""
    monkeypatch.setattr('bt_orchestrator.extensions.postgres.standing_by.WITHIN_S', 1.0)
    with closing(PostgresStore(address, tmp_path / 'a')) as leader:
        leader.append(events(1, 5))
        with closing(PostgresStandby(address, clocks, tmp_path / 'b')) as standby:
            standby.look()
            before = standby._looks.absent_at(6)
            with without_replica(person), pytest.raises(JournalAway, match='does not answer'):
                standby.look()
            assert standby._looks.absent_at(6) == before
            wait_for(lambda: standby.look().seq == 5)


def test_9_4_standby_notices_events_lost_by_database(
    address: str, person: Connection, tmp_path: Path
) -> None:
    with closing(PostgresStore(address, tmp_path / 'a')) as leader:
        leader.append(events(1, 20))
        with closing(PostgresStandby(address, clocks, tmp_path / 'b')) as standby:
            standby.look()
            mark = Mark(mark_place(place_of(address), tmp_path / 'b')).found
            assert mark is not None
            assert (mark.history, mark.seq) == (leader.history, 20)
            leader.close()
            person.execute('DELETE FROM events WHERE seq > 15')
            standby.look()
            new = standby.take()
            assert new is not None
    with closing(new):
        assert '5 events are missing: event 20 of' in new.missing(15)


def test_9_4_a_standby_outlives_cuts_of_its_connection(
    address: str, person: Connection, tmp_path: Path
) -> None:
    with closing(PostgresStore(address, tmp_path / 'a')) as leader:
        leader.append(events(1, 2))
        with closing(PostgresStandby(address, clocks, tmp_path / 'b')) as standby:
            for _ in range(5):
                assert standby.look().seq == 2
                cut(person, 'standby')
                with suppress(JournalAway):
                    standby.take()
            assert standby.look().seq == 2


def test_9_4_of_two_standbys_one_leads(address: str, tmp_path: Path) -> None:
    a, b = (PostgresStandby(address, clocks, tmp_path / name) for name in 'ab')
    with closing(a), closing(b):
        with closing(PostgresStore(address, tmp_path)) as leader:
            leader.append(events(1, 2))
            a.look()
            b.look()
        first, second = a.take(), b.take()
        assert second is None
        assert first is not None
        first.close()
        second = b.take()
        assert second is not None
        second.close()


def test_9_4_no_standby_goes_on_from_a_copy(address: str, tmp_path: Path) -> None:
    place = place_of(address)
    with connected(place, 'feed') as feed:
        enter(feed, place.cell, FEED, 'a feed')
    with (
        closing(PostgresStandby(address, clocks, tmp_path)) as standby,
        pytest.raises(JournalUnusable, match='is a copy that a feed writes'),
    ):
        standby.look()


# --- looks --------------------------------------------------------------------------------------


def at(seconds: float) -> ClockReading:
    return ClockReading(1e9 + seconds, Uptime('boot', seconds))


def test_9_4_the_last_look_without_an_event_is_remembered() -> None:
    looks = Looks()
    for seq, seconds in ((4, 1), (4, 2), (4, 3), (9, 4), (9, 5), (12, 6)):
        looks.note(seq, at(seconds))
    assert looks.absent_at(4) is None
    assert looks.absent_at(5) == at(3)
    assert looks.absent_at(9) == at(3)
    assert looks.absent_at(10) == at(5)
    assert looks.absent_at(13) == at(6)


def test_9_4_loss_invalidates_earlier_looks() -> None:
    looks = Looks()
    looks.note(9, at(1))
    looks.note(4, at(2))
    assert looks.absent_at(10) == at(2)
    assert looks.absent_at(3) is None


def test_9_4_looks_of_long_ago_are_forgotten() -> None:
    looks = Looks()
    for n in range(3000):
        looks.note(n, at(float(n)))
    assert looks.absent_at(1000) is None
    assert looks.absent_at(2990) == at(2989)
