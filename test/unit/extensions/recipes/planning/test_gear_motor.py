"""The shipped gear motor: a recipe of 31 operations becomes a script, and motors are made."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import pytest
from fakes.action_types import FakeActionTypes
from fakes.shipped import ROOT
from fakes.virtual_run import VirtualRun

from bt_orchestrator.extensions.recipes.planning.generate import generate
from bt_orchestrator.extensions.recipes.planning.outcome import Generated
from bt_orchestrator.extensions.recipes.reading.overrides_file import read_overrides
from bt_orchestrator.extensions.recipes.reading.recipe_file import read_recipe
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.fault import parse_fault
from bt_orchestrator.model.recipe import Overrides
from bt_orchestrator.script.cell_file import read_cell
from bt_orchestrator.sim.pace_judge import PaceJudge
from bt_orchestrator.store.memory import MemoryStore

TYPES = FakeActionTypes()


@cache
def line() -> Cell:
    return read_cell(ROOT / 'config' / 'gear_motor_cell.yaml', TYPES)


@cache
def made(*, overridden: bool = True) -> Generated:
    recipe = read_recipe(ROOT / 'recipes' / 'gear_motor.yaml', line(), TYPES)
    file = ROOT / 'recipes' / 'gear_motor.overrides.yaml'
    overrides = read_overrides(file, recipe, line()) if overridden else Overrides()
    return generate(line(), recipe, overrides, judge=PaceJudge(line(), TYPES, MemoryStore))


def run(quantity: int, component: str = '', *faults: str) -> VirtualRun:
    """Make some motors on a line one of whose components has faults."""
    components = dict(line().components)
    if faults:
        parsed = tuple(map(parse_fault, faults))
        components[component] = replace(components[component], faults=parsed)
    run = VirtualRun(replace(line(), components=components), TYPES)
    assert run.submit('J', made().script, quantity, lot='A7').accepted
    return run.go()


def test_the_script_is_what_the_engineer_decided() -> None:
    tasks = made().script.tasks
    assert tasks['encoder'].component == 'encoder_arm'
    assert tasks['run_in'].timeout_s == 20.0
    assert [repeat.tasks for repeat in made().script.repeats] == [('join_leads', 'joint')]


def test_all_that_is_generated_is_made() -> None:
    assert run(3).counts() == {'started': 3, 'placed': 3, 'processed': 3, 'packed': 3}


def test_the_bearings_are_pressed_where_the_bore_is() -> None:
    (rear,) = run(1).all('task.started', task='rear_bearing')
    assert rear['args'] == {'special_argument_1': 'rear', 'special_argument_2': 0.04}


def test_a_cold_joint_is_done_once_more() -> None:
    done = run(2, 'solder_laser', 'TASK_B#1=reads:0.5')
    assert [event['item'] for event in done.all('round.begun')] == ['J/1']
    assert done.counts()['packed'] == 2


@pytest.mark.parametrize(
    ('component', 'faults'),
    [
        ('solder_laser', ('TASK_B#1=reads:0.5', 'TASK_B#2=reads:0.5')),
        ('bearing_press', ('TASK_B#1=reads:6.2',)),
        ('test_bench', ('TASK_B#1=reads:0.4', 'TASK_B#2=reads:0.4')),
    ],
)
def test_what_does_not_pass_goes_to_scrap(component: str, faults: tuple[str, ...]) -> None:
    done = run(2, component, *faults)
    assert (done.counts()['packed'], done.counts()['rejected']) == (1, 1)
    assert [event['item'] for event in done.all('task.succeeded', task='into_scrap')] == ['J/1']
    assert [event['item'] for event in done.all('task.succeeded', task='into_tray')] == ['J/2']


def test_the_proof_says_what_limits_the_line() -> None:
    assert made(overridden=False).claim.per_item_s == 8.0
