"""The fold refuses what cannot have happened."""

from __future__ import annotations

from dataclasses import replace

import pytest
from fakes.line import Line

from bt_orchestrator.model import events as e
from bt_orchestrator.model import fold
from bt_orchestrator.model.codec import event_types
from bt_orchestrator.model.fold import apply
from bt_orchestrator.model.limits import ENDED_KEPT
from bt_orchestrator.model.state import CellState


def test_events_are_applied_in_order_and_once() -> None:
    state = CellState(Line().cell)
    event = e.BeatStarted(seq=1, beat=2)
    apply(state, event)
    for seq in (1, 3):
        with pytest.raises(AssertionError, match='after 1'):
            apply(state, replace(event, seq=seq))
    assert state.seq == 1


@pytest.mark.parametrize('name', event_types())
def test_every_event_has_a_fold(name: str) -> None:
    assert event_types()[name] in fold._FOLDS


def test_no_slot_holds_two() -> None:
    run = Line().begin(quantity=2).go(until=1.0)
    seq = run.state.seq + 1
    with pytest.raises(AssertionError, match='two items in slot 1'):
        apply(run.state, e.ItemPlaced(seq=seq, job='J', item='J/2', section=1))


def test_an_ended_job_leaves_nothing_but_its_record() -> None:
    run = Line().run(quantity=3)
    state = run.state
    assert list(state.ended) == ['J']
    assert not state.jobs
    assert not state.items
    assert not state.tasks
    assert not state.running
    assert not state.reserved
    assert not state.scripts
    assert not state.preparations


def test_the_oldest_ended_jobs_are_forgotten() -> None:
    line = Line(1)
    text = 'sections:\n  1: [{id: place, @a1, qty_change: 1}, {id: pack, @b1, qty_change: -1}]'
    run = line.begin(text)
    script = line.script(text)
    for number in range(ENDED_KEPT + 1):
        run.sim.submit([replace(run.job().job, id=f'K{number}', script=script)])
    run.go()
    assert len(run.state.ended) == ENDED_KEPT
    assert 'J' not in run.state.ended

    older = CellState(line.cell)
    for event in run.store.read():
        if not isinstance(event, e.JobCleared):  # journals of before have none
            apply(older, replace(event, seq=older.seq + 1))
    assert older.ended == run.state.ended
