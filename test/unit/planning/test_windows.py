"""Some sections are taken apart together, where no move of one or two pieces is better."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

from bt_orchestrator.model.recipe import Overrides
from bt_orchestrator.model.script import Script
from bt_orchestrator.planning.generate import generate
from bt_orchestrator.planning.outcome import Limits
from bt_orchestrator.planning.plans import Plan
from bt_orchestrator.planning.problem import Problem
from bt_orchestrator.planning.search import Search
from bt_orchestrator.planning.starts import starts
from bt_orchestrator.planning.windows import Windows

LINES = Path(__file__).parents[3] / 'bench/recipe_lines.py'
TIMES, NODES = 40, 20_000


class NeverAsked:
    """Nothing is shared on these lines. Implements `outcome.Judge`."""

    def pace_s(self, script: Script) -> float | None:
        raise AssertionError(script.name)


@pytest.fixture(scope='module')
def lines() -> ModuleType:
    """Give what the benchmark draws."""
    spec = importlib.util.spec_from_file_location('recipe_lines', LINES)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look there
    spec.loader.exec_module(module)
    return module


def downhill(problem: Problem) -> Plan:
    search = Search(problem.plans)
    search.run(starts(problem.plans), 0)
    assert search.best is not None
    return search.best[1]


@pytest.mark.parametrize('seed', [1, 2])
def test_it_is_better_than_what_no_move_makes_better(lines: ModuleType, seed: int) -> None:
    line = lines.drawn_line(seed, 30, candidates=4, sections=6)
    problem = Problem(line.cell, line.recipe, Overrides(), frozenset(), None)
    plans, before = problem.plans, downhill(problem)
    found = Windows(plans).better(before, TIMES, NODES)
    was, now = plans.cost(before), plans.cost(found)
    assert was is not None
    assert now is not None
    assert now.us < was.us
    assert Windows(plans).better(before, TIMES, NODES) == found, 'the same in every run'
    assert Windows(plans).better(before, TIMES, 0) == before


@pytest.mark.parametrize(('times', 'is_fastest'), [(0, False), (TIMES, True)])
def test_what_it_finds_may_be_proven_to_be_the_fastest(
    lines: ModuleType, *, times: int, is_fastest: bool
) -> None:
    line = lines.drawn_line(2, 30, candidates=4, sections=6)
    limits = Limits(kicks=0, windows=times, window_nodes=NODES, nodes=2_000)
    found = generate(line.cell, line.recipe, judge=NeverAsked(), limits=limits)
    assert found.claim.is_fastest is is_fastest
    assert (found.claim.per_item_s == line.best_s) is is_fastest
