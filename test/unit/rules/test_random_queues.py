"""Whatever is asked of the queue while jobs run: the invariants hold, and what may end ends."""

from __future__ import annotations

from random import Random

import pytest
from fakes.random_line import RandomLine
from fakes.random_queue import QueueOperator
from fakes.virtual_run import VirtualRun


def run_queue(seed: int, *, rebuild: bool = False) -> VirtualRun:
    """Run a random line with a busy operator, then let every job end."""
    line, patience = RandomLine(seed), Random(seed)
    operator = QueueOperator(line, seed)
    run = VirtualRun(line.line.cell, line.line.types, rebuild=rebuild, replays=False).go()
    for _ in range(16):
        operator.act(run)
        line.operate(run, patience)
        run.go(until=(run.sim.clock.next_deadline() or run.now) + patience.uniform(0, 15))
    assert operator.accepted
    operator.let_everything_end(run)
    for _ in range(400):
        if run.ended:
            break
        line.operate(run, patience)
        run.go(until=(run.sim.clock.next_deadline() or run.now) + patience.uniform(0, 60))
    run.check_replay()
    return run


@pytest.mark.parametrize('seed', range(8))
def test_random_queues_end(seed: int) -> None:
    """Every step is checked by `fakes.invariants` and by a replay of its events."""
    run = run_queue(seed)
    assert run.ended, run.waits()


@pytest.mark.parametrize('seed', range(100, 102))
def test_random_queues_go_on_with_a_tree_that_was_built_anew(seed: int) -> None:
    assert run_queue(seed, rebuild=True).records == run_queue(seed).records
