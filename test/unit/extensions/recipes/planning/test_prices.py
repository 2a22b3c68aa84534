"""What it costs to do an operation elsewhere, and what is proven about the pace."""

from __future__ import annotations

from dataclasses import replace

import pytest
from fakes.planned import ENDS, TYPES, cell_of, made_of, recipe_of

from bt_orchestrator.extensions.recipes.planning.generate import generate
from bt_orchestrator.extensions.recipes.planning.line_model import LineModel, Solution
from bt_orchestrator.extensions.recipes.planning.outcome import Price, Why
from bt_orchestrator.extensions.recipes.planning.planner import Problem, prices
from bt_orchestrator.sim.pace_judge import PaceJudge
from bt_orchestrator.store.memory import MemoryStore

STEPS = """
- {id: place, do: put}
- {id: pick, do: grip}
- {id: fit, do: press}
- {id: box, do: pack}
"""
PRESS = 'press: {task: TASK_B}'
BACKWARDS = (
    'impossible: items move down the belt only, and these demands contradict each other: `fit` '
    'comes after `pick`; `pick` only at picker_b in section 3; `fit` only at press_a in section 2'
)
LINE = {
    **ENDS,
    'press_a': f'section: 2, durations: {{TASK_B: 2.0}}, capabilities: {{{PRESS}}}',
    'picker_a': 'section: 2, capabilities: {grip: {task: TASK_A}}',
}


def told(components: dict[str, str]) -> dict[str, dict[str, str]]:
    """Return the price of each other component, by operation."""
    cell = cell_of(components)
    recipe = recipe_of(cell, STEPS)
    judge = PaceJudge(cell, TYPES, MemoryStore)
    made = generate(cell, recipe, judge=judge)
    costs = prices(Problem(cell, recipe), made, judge)
    return {name: {price.component: price.words for price in ways} for name, ways in costs.items()}


def picker(section: int, seconds: float) -> dict[str, str]:
    keys = f'section: {section}, durations: {{TASK_A: {seconds}}}'
    return {**LINE, 'picker_b': f'{keys}, capabilities: {{grip: {{task: TASK_A}}}}'}


@pytest.mark.parametrize(
    ('section', 'seconds', 'words'),
    [
        (2, 1.0, 'as good'),
        (2, 1.4, '+0.4 s'),
        (1, 3.0, '+1 s'),
        (
            3,
            1.0,
            BACKWARDS,
        ),
    ],
)
def test_8_5_a_price_says_what_another_component_costs(
    section: int, seconds: float, words: str
) -> None:
    assert told(picker(section, seconds))['pick'] == {'picker_b': words}


def test_8_5_price_at_equal_pace_is_the_spread() -> None:
    """The press limits the line; the pickers stand elsewhere."""
    line = {**picker(1, 1.3), 'press_a': LINE['press_a'].replace('section: 2', 'section: 3')}
    line['press_a'] = line['press_a'].replace('2.0', '9.0')
    assert told(line)['pick'] == {'picker_b': 'same pace, spread 0.3 s worse'}


@pytest.mark.parametrize(
    ('price', 'words'),
    [
        (Price('b', more_s=0.4, at_least_s=-1.0), 'at most +0.4 s'),
        (Price('b', more_s=0.4, at_least_s=0.1), '+0.1 to +0.4 s'),
        (Price('b', more_s=-0.3), '0.3 s faster'),
        (Price('b', spread_s=0.3, is_least=False), 'same pace, spread at most 0.3 s worse'),
        (Price('b', reasons=('not found',)), 'not known: not found'),
    ],
)
def test_8_5_a_price_that_is_not_proven_says_so(price: Price, words: str) -> None:
    assert price.words == words


def test_8_5_pace_differing_from_model_is_not_proven(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The script is computed anew by rule 8.4, whatever the model says."""
    best = LineModel.best

    def boastful(model: LineModel, *limits: int) -> Solution | None:
        solution = best(model, *limits)
        return solution and replace(solution, bound_us=99_000_000)

    monkeypatch.setattr(LineModel, 'best', boastful)
    claim = made_of(LINE, STEPS).claim
    assert (claim.bound_s, claim.is_fastest) == (None, False)
    assert str(claim) == '4.0 s for each item, not proven to be the fastest'


def test_8_5_unproven_reason_is_not_given() -> None:
    """With groups the model is only a bound, so nothing is called as good."""
    twin = {
        name: f'section: 2, workspaces: [{name}], capabilities: {{grip: {{task: TASK_A}}}}'
        for name in ('left', 'right')
    }
    made = made_of({**ENDS, **twin, 'press_a': LINE['press_a']}, STEPS).made
    assert made['pick'].why is Why.FOUND
