"""A journal that lacks events which were written: the line is further than it says (9.2)."""

from __future__ import annotations

import shutil
import sqlite3
from pathlib import Path

import pytest
from fakes.commands import Resume
from fakes.line import with_section
from fakes.operator import ann
from fakes.plant import Plant

from bt_orchestrator.model import events as e
from bt_orchestrator.store.shared.mark import mark_of


@pytest.fixture
def plant(tmp_path: Path) -> Plant:
    return Plant(tmp_path)


def forget(plant: Plant) -> None:
    """Put the files back as `keep` saw them, but for the mark, and start a node."""
    plant.end()
    for ending in ('', '-wal'):
        plant.path.with_name(plant.path.name + ending).unlink(missing_ok=True)
    for file in (plant.path.parent / 'kept').iterdir():
        shutil.copy(file, plant.path.parent)
    plant.start(auto_resume=True)
    plant.go()


def keep(plant: Plant) -> None:
    folder = plant.path.parent / 'kept'
    folder.mkdir()
    for ending in ('', '-wal'):
        shutil.copy(plant.path.with_name(plant.path.name + ending), folder)


def assert_waits(plant: Plant) -> None:
    """Nothing starts, whatever is said but the number of the hold."""
    before = len(plant.events(e.TaskStarted))
    for everyones in (False, True):
        assert not plant.orchestrator.ask(Resume(ann('go'), everyones=everyones)).accepted
        plant.go()
    assert len(plant.events(e.TaskStarted)) == before
    assert plant.holds() == ['missing']


def release(plant: Plant) -> None:
    hold = next(h.id for h in plant.state.holds.values() if h.reason == 'missing')
    assert plant.orchestrator.ask(Resume(ann('compared'), hold)).accepted
    plant.go()


def test_9_2_missing_events_hold_cell_until_checked(plant: Plant) -> None:
    plant.add('BEFORE')
    plant.go()
    keep(plant)
    history, kept = plant.store.history, plant.state.seq
    plant.add('LOST')
    plant.go()
    lost = plant.state.seq - kept
    forget(plant)
    plant.add('NEXT')
    assert_waits(plant)
    (hold,) = plant.state.holds.values()
    assert hold.message.startswith(f'{lost} events are missing: event {kept + lost} of 2023-11-14')
    assert f'The journal ends with event {kept} of 2023-11-14' in hold.message
    assert 'compare belt, counts and queue' in hold.message
    release(plant)
    assert plant.state.ended.keys() == {'BEFORE', 'NEXT'}
    started = plant.events(e.OrchestratorStarted)[-1]
    assert isinstance(started, e.OrchestratorStarted)
    assert started.missing == hold.message.partition('. The journal')[0]
    assert started.history == plant.store.history != history
    plant.end()
    plant.start(auto_resume=True)
    assert plant.holds() == []
    plant.end()


def test_9_2_journal_file_copied_alone_holds_cell(plant: Plant) -> None:
    """As scripts make backups while a node runs; here it is another computer that starts on it."""
    plant.add('BEFORE')
    plant.go()
    alone = plant.path.read_bytes()
    plant.add('LOST')
    plant.go()
    history = plant.store.history
    plant.end()
    mark_of(plant.path).unlink()
    plant.path.write_bytes(alone)
    plant.start(auto_resume=True)
    plant.go()
    plant.add('NEXT')
    assert_waits(plant)
    (hold,) = plant.state.holds.values()
    assert 'may be missing: the node that wrote the journal did not close it' in hold.message
    release(plant)
    assert 'NEXT' in plant.state.ended
    assert 'LOST' not in plant.state.ended
    assert plant.store.history != history
    plant.end()


def test_9_2_it_waits_on_through_a_restart(plant: Plant) -> None:
    plant.add('BEFORE')
    plant.go()
    keep(plant)
    plant.add('LOST')
    plant.go()
    forget(plant)
    plant.end()
    plant.start(auto_resume=True)
    plant.go()
    assert_waits(plant)
    release(plant)
    plant.end()


def test_9_2_missing_events_prevent_goal_resend(plant: Plant) -> None:
    plant.gateway.unsent = 'TASK_B'
    plant.add('J', with_section(2, '- {id: work, @a2.TASK_B, repeatable: true}'), 1)
    plant.go_until_starts('work')
    plant.gateway.unsent = None
    keep(plant)
    plant.add('LOST')
    forget(plant)
    assert sorted(plant.holds()) == ['in_doubt', 'missing']
    assert not plant.events(e.TaskResent)
    plant.end()


def test_9_2_damaged_record_holds_cell_and_keeps_file(plant: Plant) -> None:
    plant.add('J')
    plant.go_until_starts('pack')
    plant.end()
    database = sqlite3.connect(plant.path)
    last = plant.state.seq
    database.execute("UPDATE events SET record = 'lost' WHERE seq = ?", (last - 4,))
    database.commit()
    database.close()
    plant.start(auto_resume=True)
    plant.go()
    assert 'missing' in plant.holds()
    assert list(plant.path.parent.glob('*.damaged-*Z'))
    release(plant)
    plant.end()


def test_9_2_restored_journal_lacking_events_has_one_hold(plant: Plant) -> None:
    plant.add('BEFORE')
    plant.go()
    plant.bring_back()
    assert plant.holds() == ['restored']
    plant.end()
