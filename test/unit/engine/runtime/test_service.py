"""Components out of service, over kills, restarts and snapshots (semantics 7.5)."""

from __future__ import annotations

import itertools
import json
from dataclasses import replace

import pytest
from fakes.commands import SetService
from fakes.line import THREE, Line, with_section
from fakes.operator import ann
from fakes.world import World, begun, killed_at_work

from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.model import events as e
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.keeping.snapshot import state_from_plain, state_to_text

LINE = Line()
OUT, BACK = SetService('a2', False, ann('worn')), SetService('a2', True, ann('mended'))


def goals_of(world: World, component: str) -> list[float]:
    """Return when a component was sent goals."""
    started = [event for event in world.events(e.TaskStarted) if isinstance(event, e.TaskStarted)]
    return [event.time for event in started if event.component == component]


def queued(world: World) -> Orchestrator:
    """Return an orchestrator with J, and K behind it."""
    first = begun(world, LINE.script(THREE), 2)
    assert first.ask(AddJobs((Job('K', LINE.script(THREE), 1),))).accepted
    return first


@pytest.mark.parametrize('after', [0, 1])
def test_7_5_out_of_service_record_survives_kill(after: int) -> None:
    """Whenever it comes, and whether or not anything follows the record.

    :param after: settles between the record and the end of the process
    """
    kills = 0
    for settles in itertools.count(1):
        world = World(LINE.cell)
        first = queued(world)
        world.go(first, settles)
        if not first.state.jobs:
            break
        assert first.ask(OUT).accepted
        before = goals_of(world, 'a2')
        world.go(first, after)
        first.close()
        second = world.orchestrator()
        world.go(second)
        assert 'a2' in second.state.out_of_service
        assert goals_of(world, 'a2') == before
        assert second.ask(BACK).accepted
        second.close()
        third = world.orchestrator()
        world.go(third)
        assert not third.state.jobs, f'killed after {settles} settles'
        ended = third.state.ended
        assert (ended['J'].progress.packed, ended['K'].progress.packed) == (2, 1)
        third.close()
        kills += 1
    assert kills > 10


@pytest.mark.parametrize('repeatable', [True, False])
def test_7_5_lost_goal_waits_until_component_is_in_service(*, repeatable: bool) -> None:
    world = World(Line(faults={'a2': '#1=die:0.5'}).cell)
    option = ', repeatable: true' if repeatable else ''
    killed_at_work(world, LINE.script(with_section(2, f'- {{id: work, @a2{option}}}')))
    world.clock.advance()  # the server dies
    world.clock.advance()  # and is back, knowing nothing
    second = world.orchestrator()
    assert second.ask(OUT).accepted
    world.go(second)
    assert not world.events(e.TaskResent)
    assert bool(second.state.holds) is not repeatable, 'what is not sent again needs an answer'
    assert second.ask(BACK).accepted
    world.go(second)
    assert bool(world.events(e.TaskResent)) is repeatable
    second.close()


def test_7_5_a_snapshot_keeps_it() -> None:
    world = World(LINE.cell)
    first = queued(world)
    assert first.ask(OUT).accepted
    assert first.state.jobs['K'].unavailable == ('a2',)
    text = state_to_text(first.state)
    again = state_from_plain(LINE.cell, json.loads(text))
    assert again.out_of_service == first.state.out_of_service
    assert again.jobs['K'].unavailable == ('a2',)
    assert state_to_text(again) == text
    first.close()


def test_7_5_record_ends_when_component_is_removed() -> None:
    world = World(LINE.cell)
    first = world.orchestrator()
    assert first.ask(SetService('lamp', False, ann('dark'))).accepted
    world.go(first)
    first.close()
    less = {name: entry for name, entry in LINE.cell.components.items() if name != 'lamp'}
    world.cell = replace(LINE.cell, components=less)
    second = world.orchestrator()
    world.go(second)
    assert second.state.out_of_service == {}
    assert [entry.component for entry in world.events(e.ComponentInService)] == ['lamp']  # type: ignore[attr-defined]
    second.close()
