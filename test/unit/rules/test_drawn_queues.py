"""Whatever is asked of cell and queue while jobs run: what may end ends."""

from __future__ import annotations

from random import Random

import pytest
from fakes.drawn.lines import lines
from fakes.drawn.plan import Plan, Traits
from fakes.drawn.queues import QueueOperator
from fakes.event_format import mistake_in
from fakes.plan_runs import ProductBench, refused, show
from fakes.profiles import examples
from hypothesis import given
from hypothesis import strategies as st

pytestmark = pytest.mark.timeout(24 * 3600)

PATIENCE = 400
"""Rounds in which an operator answers everything: far more than any drawn line needs."""


@pytest.mark.long
@examples(40, 300)
@given(lines(Traits(most_sections=5)), st.randoms())
def test_drawn_queues_end(plan: Plan, chance: Random) -> None:
    """Every settle is checked by `fakes.invariants` and by a replay of its events."""
    show(plan)
    bench = ProductBench(plan.without_flags(refused(plan)))
    run = bench.run.go()
    operator = QueueOperator(list(bench.scripts.values()), chance)
    for _ in range(6):
        operator.act(run)
        run.go(until=(run.sim.clock.next_deadline() or run.now) + chance.uniform(0, 15))
    operator.let_everything_end(run)
    for _ in range(PATIENCE):
        if run.ended:
            break
        operator.answer(run)
        run.go(until=(run.sim.clock.next_deadline() or run.now) + chance.uniform(0, 60))
    assert run.ended, run.waits()
    assert [mistake for mistake in map(mistake_in, run.records) if mistake] == []
