"""Guards wait while their task is new, and let pass what is under way or done."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypeVar

from fakes.line import THREE, Line
from fakes.virtual_run import VirtualRun
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from bt_orchestrator.engine.tree.guards import ConveyorGuard, FlagGuard, ReadyGuard, ZoneGuard

_Kind = TypeVar('_Kind', bound=Behaviour)

GUARDED = """
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2: [{id: work, @a2}, {id: rest, @b2}]
  3: [{id: pack, @a3, qty_change: -1}]
lateral_dependencies: [{flag: one, upstream: place, downstream: work}]
zones: {table: [work, pack]}
"""


def behaviours(run: VirtualRun, kind: type[_Kind]) -> Iterator[_Kind]:
    """Yield the behaviours of one class in the tree."""
    for behaviour in run.sim.orchestrator.tree.root.iterate():
        if isinstance(behaviour, kind):
            yield behaviour


def flag_of(run: VirtualRun, task: str) -> FlagGuard:
    """Return the flag guard of a task."""
    return next(g for g in behaviours(run, FlagGuard) if g.subject.task.id == task)


def test_a_guard_waits_while_its_task_is_new() -> None:
    text = GUARDED.replace('upstream: place, downstream: work', 'upstream: pack, downstream: work')
    run = Line().begin(text).go(until=3.0)
    guard = flag_of(run, 'work')
    assert guard.status is Status.RUNNING
    assert guard.feedback_message == 'waiting for pack to set flag one'
    assert guard.decorated.status is Status.INVALID


def test_guard_passes_when_task_runs_or_is_done() -> None:
    run = Line(seconds={'b2': 5.0}).begin(GUARDED).go(until=3.0)
    guard = flag_of(run, 'work')
    assert guard.waits_for() is None  # it runs, and the flag is still there
    run.go(until=4.0)
    assert run.state.flags['one'].count == 0  # taken by `work` itself
    assert guard.waits_for() is None
    assert guard.status is Status.SUCCESS


def test_zone_does_not_block_task_inside_it() -> None:
    run = Line().begin(GUARDED).go(until=3.0)
    guards = {g.subject.task.id: g for g in behaviours(run, ZoneGuard)}
    assert run.state.zones['table'].task == 'work'
    assert guards['work'].waits_for() is None


def test_busy_component_does_not_block_its_own_task() -> None:
    line = Line(topics=('a2',), faults={'a2': '#1=not_ready:2'})
    run = line.begin(GUARDED).go(until=4.0)
    (guard,) = behaviours(run, ReadyGuard)
    assert not run.state.readings['a2'].ready
    assert guard.waits_for() is None  # the task is done


def test_moving_belt_does_not_block_completed_step() -> None:
    text = THREE.replace(
        '2: [{id: work, @a2}]',
        '2: {release_conveyor: after_last_conveyor_task, tasks: '
        '[{id: work, @a2}, {id: clean, @b2, requires_conveyor: false}]}',
    )
    run = Line(seconds={'b2': 5.0}).begin(text).go(until=4.0)
    assert run.state.indexing
    guard = next(g for g in behaviours(run, ConveyorGuard) if g._section == 2)
    assert guard.waits_for() is None
    assert run.starts('clean') == [4.0]
