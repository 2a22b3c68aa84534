"""Releases of generated scripts, over kills, restarts, other cell files and snapshots (6.10)."""

from __future__ import annotations

import itertools
import json
from dataclasses import replace

import pytest
from fakes.commands import ReleaseScript
from fakes.line import THREE, Line
from fakes.operator import ann
from fakes.world import World, begun

from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.keeping.snapshot import state_from_plain, state_to_plain, state_to_text
from bt_orchestrator.sim.run_on import RunOn

LINE = Line()
GENERATED = LINE.script(f'made_from: {{recipe: WM-100, version: 3}}\n{THREE}', 'made')
RELEASE = ReleaseScript(digest(GENERATED), ann('read it'))


def queued(world: World) -> Orchestrator:
    """Return an orchestrator with J on the line, and K behind it, which nobody has released."""
    first = begun(world, LINE.script(THREE), 1)
    assert first.ask(AddJobs((Job('K', GENERATED, 1),))).accepted
    return first


@pytest.mark.parametrize('after', [0, 1])
def test_6_10_release_survives_kills_and_starts_nothing_else(
    after: int,
) -> None:
    """Whenever it comes, and whether or not anything follows the record.

    :param after: settles between the record and the end of the process
    """
    for settles in itertools.count(1):
        world = World(LINE.cell)
        first = queued(world)
        world.go(first, settles)
        has_ended = 'J' not in first.state.jobs
        first.close()
        second = world.orchestrator()
        world.go(second)
        assert list(second.state.jobs) == ['K']
        assert second.state.jobs['K'].awaits_release
        assert second.ask(RELEASE).accepted
        world.go(second, after)
        second.close()
        third = world.orchestrator()
        world.go(third)
        assert not third.state.jobs, f'killed after {settles} settles'
        assert third.state.ended['K'].progress.packed == 1
        third.close()
        if has_ended:
            break
    assert settles > 5


def test_6_10_release_belongs_to_its_cell_file() -> None:
    world = World(LINE.cell)
    first = world.orchestrator()
    assert first.ask(RELEASE).accepted
    first.close()
    world.cell = replace(LINE.cell, name='another')
    second = world.orchestrator()
    assert 'is not released' in second.ask(AddJobs((Job('K', GENERATED, 1),))).message
    assert second.ask(RELEASE).accepted
    world.go(second)
    assert not second.state.jobs
    second.close()
    world.cell = LINE.cell
    third = world.orchestrator()
    assert third.ask(AddJobs((Job('L', GENERATED, 1),))).message == 'L is queued'
    third.close()


def test_6_10_a_snapshot_keeps_it() -> None:
    world = World(LINE.cell)
    first = queued(world)
    assert first.state.jobs['K'].awaits_release
    text = state_to_text(first.state)
    again = state_from_plain(LINE.cell, json.loads(text))
    assert again.jobs['K'].awaits_release
    assert state_to_text(again) == text
    first.ask(RELEASE)
    again = state_from_plain(LINE.cell, state_to_plain(first.state))
    assert again.released == first.state.released == {digest(GENERATED): (digest(LINE.cell),)}
    first.close()


def test_6_10_forecast_knows_release_despite_other_durations() -> None:
    world = World(LINE.cell)
    first = queued(world)
    waiting = RunOn(LINE.cell, LINE.types, state_to_plain(first.state), {}, 0.0)
    assert waiting.state.jobs['K'].awaits_release
    waiting.close()
    assert first.ask(RELEASE).accepted
    observed_s = {'a2': {'TASK_A': 7.0}}
    forecast = RunOn(LINE.cell, LINE.types, state_to_plain(first.state), observed_s, 0.0)
    answer = forecast.orchestrator.ask(AddJobs((Job('L', GENERATED, 1),)))
    assert answer.message == 'L is queued'
    forecast.close()
    first.close()
