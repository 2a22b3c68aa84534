"""The reference process with nominal durations: every start and end, worked out by hand.

Durations from config/reference_cell.yaml: HOME 2, PREPARE of both arms 1, pick 1.5, place 1,
2.1 3, 3.1 2.5, 4.1 1, 4.2 1, 4.3 1.5, 4.4 1, pack 2, index move 2.

Initialization (semantics 5). `home_belt` and `prepare_packing` wait for nothing: 0. The unpacking
arm is prepared after `home_belt`: 2 to 3. The source needs `home_belt` (no section) and
`prepare_unpacking` (its own): item 1 begins at 3. `prepare_packing` is for section 5 alone.

Beats (semantics 3). At the end of a beat stands the section that completes its turn last; the belt
then moves for 2 s, and every step that requires the conveyor starts when it rests again. `pick`
does not require it (3.7): it starts when the source's next turn is known, which is when its own
cycle completes, but never more than one cycle ahead.

    beat  at rest from  last turn, complete at         so the belt moves
    1     0             place of item 1, 5.5           5.5 to 7.5
    2     7.5           2.1 of item 1, 7.5 + 3         10.5 to 12.5
    3     12.5          2.1 of item 2, 12.5 + 3        15.5 to 17.5
    4     17.5          4.4 of item 1, 17.5 + 4.5      22 to 24
    5     24            4.4 of item 2, 24 + 4.5        28.5 to 30.5
    6     30.5          4.4 of item 3, 30.5 + 4.5      35 to 37
    7     37            pack of item 3, 37 + 2: the job is complete at 39

The source has cycles for items 1 to 3 only. `pick` of item 2 follows the place of item 1 at 5.5,
while the belt moves, and is done at 7; `place` waits for 7.5. `pick` of item 3 follows the place
of item 2 at 8.5, while section 2 still works in beat 2; `place` waits for 12.5.
"""

from __future__ import annotations

from typing import NamedTuple

import pytest
from fakes.action_types import FakeActionTypes
from fakes.shipped import REFERENCE_CELL, TREES

from bt_orchestrator.model import events as e
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.script.cell_file import read_cell
from bt_orchestrator.script.script_file import read_script
from bt_orchestrator.sim.simulation import Outcome, Simulation
from bt_orchestrator.store.memory import MemoryStore


class Ran(NamedTuple):
    """One task: in which section, for which item, from when to when."""

    section: int | None
    item: int | None
    task: str
    start: float
    end: float


BY_HAND = {
    # initialization
    Ran(None, None, 'home_belt', 0.0, 2.0),
    Ran(None, None, 'prepare_packing', 0.0, 1.0),
    Ran(None, None, 'prepare_unpacking', 2.0, 3.0),
    # beat 1
    Ran(1, 1, 'pick', 3.0, 4.5),
    Ran(1, 1, 'place', 4.5, 5.5),
    Ran(None, None, 'index', 5.5, 7.5),
    Ran(1, 2, 'pick', 5.5, 7.0),
    # beat 2
    Ran(2, 1, '2.1', 7.5, 10.5),
    Ran(1, 2, 'place', 7.5, 8.5),
    Ran(1, 3, 'pick', 8.5, 10.0),
    Ran(None, None, 'index', 10.5, 12.5),
    # beat 3
    Ran(3, 1, '3.1', 12.5, 15.0),
    Ran(2, 2, '2.1', 12.5, 15.5),
    Ran(1, 3, 'place', 12.5, 13.5),
    Ran(None, None, 'index', 15.5, 17.5),
    # beat 4
    Ran(4, 1, '4.1', 17.5, 18.5),
    Ran(4, 1, '4.2', 18.5, 19.5),
    Ran(4, 1, '4.3', 19.5, 21.0),
    Ran(4, 1, '4.4', 21.0, 22.0),
    Ran(3, 2, '3.1', 17.5, 20.0),
    Ran(2, 3, '2.1', 17.5, 20.5),
    Ran(None, None, 'index', 22.0, 24.0),
    # beat 5
    Ran(5, 1, 'pack', 24.0, 26.0),
    Ran(4, 2, '4.1', 24.0, 25.0),
    Ran(4, 2, '4.2', 25.0, 26.0),
    Ran(4, 2, '4.3', 26.0, 27.5),
    Ran(4, 2, '4.4', 27.5, 28.5),
    Ran(3, 3, '3.1', 24.0, 26.5),
    Ran(None, None, 'index', 28.5, 30.5),
    # beat 6
    Ran(5, 2, 'pack', 30.5, 32.5),
    Ran(4, 3, '4.1', 30.5, 31.5),
    Ran(4, 3, '4.2', 31.5, 32.5),
    Ran(4, 3, '4.3', 32.5, 34.0),
    Ran(4, 3, '4.4', 34.0, 35.0),
    Ran(None, None, 'index', 35.0, 37.0),
    # beat 7
    Ran(5, 3, 'pack', 37.0, 39.0),
}

MOVES = {
    # item, section moved into, when the belt came to rest
    (1, 2, 7.5),
    (1, 3, 12.5),
    (2, 2, 12.5),
    (1, 4, 17.5),
    (2, 3, 17.5),
    (3, 2, 17.5),
    (1, 5, 24.0),
    (2, 4, 24.0),
    (3, 3, 24.0),
    (2, 5, 30.5),
    (3, 4, 30.5),
    (3, 5, 37.0),
}


@pytest.fixture(scope='module')
def events() -> list[e.Event]:
    types = FakeActionTypes()
    cell = read_cell(REFERENCE_CELL, types)
    script = read_script(TREES / 'reference_process.yaml', cell, types)
    store = MemoryStore()
    simulation = Simulation(cell, types, store)
    simulation.submit([Job('WO', script, 3, {'label': 'none'})])
    assert simulation.run() is Outcome.FINISHED
    simulation.close()
    return list(store.read())


def ran(events: list[e.Event]) -> list[Ran]:
    started: dict[e.TaskKey, float] = {}
    runs = []
    for event in events:
        if isinstance(event, e.TaskStarted):
            started[event.key] = event.time
        elif isinstance(event, e.TaskSucceeded):
            item = None if event.item is None else int(event.item.split('/')[1])
            start = started.pop(event.key)
            runs.append(Ran(event.section, item, event.task, start, event.time))
    assert not started
    return runs


def test_tasks_start_and_end_as_durations_predict(events: list[e.Event]) -> None:
    runs = ran(events)

    assert set(runs) == BY_HAND
    assert len(runs) == len(BY_HAND)


def test_every_item_moves_when_belt_stops(events: list[e.Event]) -> None:
    moved = [event for event in events if isinstance(event, e.ItemMoved)]

    assert {(int(m.item[-1]), m.section, m.time) for m in moved} == MOVES
    assert len(moved) == len(MOVES)


def test_the_job_ends_with_its_last_item(events: list[e.Event]) -> None:
    assert [event.time for event in events if isinstance(event, e.JobCompleted)] == [39.0]
