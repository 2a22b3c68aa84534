"""Drawn lines on real ROS 2 action servers: each section sees the same order as in virtual time.

Only lines are taken of which the order cannot depend on when a result arrives: it is the same in
virtual runs with very different delays.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from random import Random
from typing import Any

import pytest
from cell_processes import StartCell
from fakes.drawn.lines import lines
from fakes.drawn.plan import Plan, Traits
from fakes.plan_runs import ProductBench, text_of
from fakes.profiles import PROFILE
from hypothesis import HealthCheck, Phase, given, seed, settings

COUNT = 2 if PROFILE == 'gate' else 20
SPEED = 10
LONGEST_S = 120.0
"""Of simulated time."""
LEAST = 12
"""Items times sections of a line that is worth while."""

SPACED = Traits(shared=False, faults=False, tied=False)

Order = Mapping[int, Sequence[tuple[str, str | None, str | None]]]
"""Events of each section, with item and task."""


def order_of(records: Sequence[Mapping[str, Any]]) -> Order:
    steps: dict[int, list[Any]] = {}
    for record in records:
        if 'section' in record:
            about = (record['event'], record.get('item'), record.get('task'))
            steps.setdefault(record['section'], []).append(about)
    return steps


def run(plan: Plan, late: Random | None = None) -> ProductBench:
    """Run a line in virtual time, each goal so much later than it should be."""
    bench = ProductBench(plan)
    if late is not None:
        spread = tuple(late.uniform(0.0, 5.0) for _ in range(97))
        bench = ProductBench(replace(plan, seconds=spread))
    bench.run.go()
    return bench


def expected(plan: Plan) -> Order | None:
    """Return the order of a line that ends by itself, soon enough, whatever the delays."""
    bench = run(plan)
    records = bench.run.records
    if bench.live or records[-1]['time'] > LONGEST_S:
        return None
    order = order_of(records)
    others = (run(plan, Random(number)) for number in range(4))
    return order if all(order_of(other.run.records) == order for other in others) else None


class _Enough(BaseException):
    """No exception to Hypothesis: it draws no more."""


def sample(count: int) -> list[Plan]:
    """Draw lines until there are enough that fit."""
    plans: list[Plan] = []

    @seed(4)
    @settings(
        max_examples=100 * count,
        deadline=None,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(lines(SPACED))
    def draw(plan: Plan) -> None:
        # A start is a time of the calendar, and the time of the virtual run begins with 0.
        orders = tuple(
            job._replace(priority=0, start=None, setup=0.0) for job in (*plan.orders, *plan.later)
        )
        cell = {**plan.cell, 'release': 'automatic'}  # nobody is there to release a script
        alone = replace(plan, cell=cell, orders=orders, later=(), moments=(), rebuilds=frozenset())
        size = sum(order.quantity for order in orders) * plan.cell['conveyor']['sections']
        if size >= LEAST and expected(alone) is not None:
            plans.append(alone)
        if len(plans) == count:
            raise _Enough

    with pytest.raises(_Enough):
        draw()
    return plans


@pytest.mark.timeout(3600)
def test_section_order_matches_virtual_time(start_cell: StartCell) -> None:
    for number, plan in enumerate(sample(COUNT)):
        cell = start_cell(text_of(plan.cell), folder=f'line_{number}', speed=SPEED)
        cell.connect()
        for script in plan.scripts:
            cell.script(text_of(script), script['script'])
        for order in plan.orders:
            cell.watch.submit(order.script, quantity=order.quantity, order=order.id)
        for order in plan.orders:
            cell.watch.until_ended(order.id, within_s=4 * LONGEST_S)
        assert order_of(cell.watch.events) == expected(plan), text_of(plan.cell)
        cell.stop()
