"""Any past moment of a cell, with its reasons, equals what was shown then."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import pytest
from fakes.action_types import FakeActionTypes
from fakes.commands import AnswerHold, Pause, Resume, SetService
from fakes.line import THREE, Line
from fakes.operator import ann

from bt_orchestrator.base.errors import NotKept
from bt_orchestrator.engine.runtime.overview import Overview
from bt_orchestrator.model.events import (
    ClockStepped,
    ComponentStateChanged,
    Event,
    OperatorDecided,
    RequestRefused,
)
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.status import CellStatus, TaskStatus
from bt_orchestrator.sim.past import JournalPast
from bt_orchestrator.sim.simulation import Simulation
from bt_orchestrator.store.memory import MemoryRecords, MemoryStore

FLAGGED = THREE + 'lateral_dependencies: [{flag: clear, upstream: work, downstream: pack}]\n'


def _nothing() -> None:
    pass


class _Shown:
    """Keeps what was shown after each settle."""

    def __init__(self) -> None:
        self.at: dict[int, CellStatus] = {}
        self.look: Callable[[], None] = _nothing

    def publish(self, events: Sequence[Event]) -> None:
        self.look()


def unfed(tasks: tuple[TaskStatus, ...]) -> tuple[TaskStatus, ...]:
    return tuple(replace(task, feedback='', expected_s=None) for task in tasks)


def as_then(status: CellStatus) -> CellStatus:
    """Leave out what no journal knows."""
    return replace(
        status,
        sections=tuple(replace(part, running=unfed(part.running)) for part in status.sections),
        belt=replace(status.belt, running=unfed(status.belt.running)),
        components=tuple(replace(part, feedback='') for part in status.components),
    )


@pytest.mark.parametrize('text', [THREE, FLAGGED], ids=['free', 'flagged'])
def test_every_settle_is_shown_as_it_was(text: str) -> None:
    line = Line(3, seconds={'a2': 5.0}, faults={'a2': '#2=abort'})
    store, shown = MemoryStore(), _Shown()
    simulation = Simulation(line.cell, FakeActionTypes(), store, [shown])
    overview = Overview(simulation.orchestrator)

    def look() -> None:
        shown.at[simulation.state.seq] = overview.status(simulation.clock.now())

    shown.look = look
    simulation.submit(Job(name, line.script(text), 3) for name in ('A', 'B'))
    paused = False
    while simulation.state.jobs:
        assert simulation.clock.advance() or simulation.state.holds
        simulation.orchestrator.settle()
        if simulation.clock.now() > 20.0 and not paused:
            paused = True
            simulation.orchestrator.ask(Pause(ann()))
            simulation.orchestrator.settle()
            simulation.orchestrator.ask(Resume(ann()))
        for hold in list(simulation.state.holds.values()):
            simulation.orchestrator.ask(AnswerHold(hold.id, 'retry', ann()))
    past = JournalPast(line.cell, MemoryRecords(store))
    assert len(shown.at) > 20
    for seq, status in shown.at.items():
        assert as_then(past.status_at(seq, status.stamp)) == as_then(status), seq
    simulation.close()


def test_moment_within_a_settle_has_its_own_facts() -> None:
    line = Line(3)
    store = MemoryStore()
    simulation = Simulation(line.cell, FakeActionTypes(), store)
    simulation.submit([Job('A', line.script(THREE), 1)])
    simulation.run()
    past = JournalPast(line.cell, MemoryRecords(store))
    for event in store.read():
        assert past.status_at(event.seq).seq == event.seq
    simulation.close()


def standing(line: Line) -> tuple[JournalPast, int, float, Simulation]:
    """Return a past in which `a2` was out of service for long, and where that began."""
    store = MemoryStore()
    simulation = Simulation(line.cell, FakeActionTypes(), store)
    simulation.submit([Job('A', line.script(THREE), 1)])
    simulation.orchestrator.ask(SetService('a2', False, ann()))
    simulation.run()
    seq, since = simulation.state.seq, simulation.state.time
    simulation.clock.call_at(since + 600.0, lambda: None)
    simulation.clock.advance()
    simulation.orchestrator.ask(SetService('a2', True, ann()))
    simulation.run()
    return JournalPast(line.cell, MemoryRecords(store)), seq, since, simulation


def test_7_4_a_past_moment_tells_why_the_cell_stood() -> None:
    past, seq, since, simulation = standing(Line(3))
    status = past.status_at(seq)
    assert status.stands is not None
    assert (status.stands.cause.value, status.stands.name) == ('out_of_service', 'a2')
    assert (status.stamp, status.stands.since) == (since, since)
    assert all(job.end_unknown for job in status.jobs)
    simulation.close()


@pytest.mark.parametrize(('after_s', 'is_told'), [(0.5, False), (1.0, True), (300.0, True)])
def test_7_4_past_moment_between_two_events_is_exact(after_s: float, is_told: bool) -> None:
    past, seq, since, simulation = standing(Line(3))
    status = past.status_at(seq, since + after_s)
    assert (status.stands is not None) is is_told
    assert status.stamp == since + after_s
    simulation.close()


@pytest.mark.parametrize('step_s', [0.0, -50.0, 3600.0])
def test_7_4_unrelated_events_do_not_begin_a_standstill(step_s: float) -> None:
    line = Line(3, faults={'a2': '#1=abort'}, topics=('a3',))
    store = MemoryStore()
    simulation = Simulation(line.cell, FakeActionTypes(), store)
    simulation.submit([Job('A', line.script(THREE), 1)])
    simulation.run()
    live = Overview(simulation.orchestrator)
    before = live.status(simulation.clock.now() + 60.0).stands
    assert before is not None
    comment = OperatorDecided(answer='comment', who='Ann', reason='I look', hold='1')
    reading = ComponentStateChanged(component='a3', ready=True, value='READY')
    refused = RequestRefused(who='x', count=2, commands={'job.move': 2}, since=0.0)
    quiet: list[Event] = [comment, reading, refused]
    if step_s:
        quiet.append(ClockStepped(seconds=step_s))
    seq, time = simulation.state.seq, simulation.clock.now()
    store.append(
        [
            event.stamped(
                seq + n, time + 60.0 * n + (step_s if event.event == 'clock.stepped' else 0.0)
            )
            for n, event in enumerate(quiet, 1)
        ]
    )
    past = JournalPast(line.cell, MemoryRecords(store))
    after = past.status_at(seq + len(quiet), time + 60.0 * (len(quiet) + 1) + step_s).stands
    assert after is not None
    assert after == replace(before, since=before.since + step_s)
    simulation.close()


def test_7_4_between_two_events_of_a_moment_nothing_stood() -> None:
    past, seq, _since, simulation = standing(Line(3))
    standstills = [past.status_at(number).stands for number in range(1, seq)]
    assert not any(standstills), 'the line worked on to its standstill'
    simulation.close()


def test_what_cannot_be_had_is_said() -> None:
    line = Line(3)
    store = MemoryStore()
    simulation = Simulation(line.cell, FakeActionTypes(), store)
    simulation.submit([Job('A', line.script(THREE), 1)])
    simulation.run()
    past = JournalPast(line.cell, MemoryRecords(store))
    with pytest.raises(NotKept, match='event 9999 is not in the journal: it has events 1 to'):
        past.status_at(9999)
    other = JournalPast(Line(3, seconds={'a2': 9.0}).cell, MemoryRecords(store))
    with pytest.raises(NotKept, match='the cell file was another one'):
        other.status_at(10)
    simulation.close()
