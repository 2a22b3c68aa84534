"""What is told of waits, over lines that nobody wrote by hand (semantics 7.4)."""

from __future__ import annotations

from collections import Counter

import pytest
from fakes.drawn.lines import lines
from fakes.drawn.plan import Plan
from fakes.obstacles import Obstacles
from fakes.plan_operator import operate
from fakes.plan_runs import ProductBench, show
from fakes.profiles import PROFILE, examples
from fakes.told_waits import recorded_as_told
from hypothesis import given

pytestmark = pytest.mark.timeout(24 * 3600)

OFTEN = ('hold', 'turn', 'belt', 'cell_state', 'flag', 'component')
"""Waits that drawn lines have in any case."""


@pytest.mark.long
def test_7_4_waits_name_real_obstacles_as_journal_does() -> None:
    """With faults, answers, commands, orders and repairs at any time.

    That each standing item has a goal or a wait is checked after each settle (`VirtualRun`).
    """
    seen: Counter[str] = Counter()

    @examples(100, 1000)
    @given(lines())
    def holds(plan: Plan) -> None:
        show(plan)
        bench = ProductBench(plan)
        obstacles = Obstacles(bench.run, every=9)
        operate(bench, plan.moments)
        seen['all'] += 1
        seen['recorded'] += recorded_as_told(bench.run)
        seen.update(kind.value for kind in obstacles.kinds.elements())

    holds()
    if PROFILE == 'shard':
        return  # a round has too few lines for shares of them
    assert seen['all'] >= 100, seen
    assert seen['recorded'] >= 10 * seen['all'], seen
    assert [kind for kind in OFTEN if not seen[kind]] == [], seen
