"""Whatever the script, the faults and the operators: the invariants hold and every job ends."""

from __future__ import annotations

import pytest
from fakes.random_line import RandomLine

SEEDS = range(12)


@pytest.mark.parametrize('seed', SEEDS)
def test_random_lines_end(seed: int) -> None:
    """Every step of a run is checked by `fakes.invariants` and by a replay of its events."""
    run = RandomLine(seed).run(seed=seed)
    assert run.ended, run.waits()


@pytest.mark.parametrize('seed', range(100, 105))
def test_random_lines_go_on_with_a_tree_that_was_built_anew(seed: int) -> None:
    """The tree holds no progress (semantics 9.1)."""
    line = RandomLine(seed)
    assert line.run(seed=seed, rebuild=True).records == line.run(seed=seed).records
