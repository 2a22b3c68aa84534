"""What holds for every line, over lines that nobody wrote by hand (semantics, all of it).

`fakes.naive_cell` is a second opinion, written from the rules; it shares nothing with the product.
`fakes.invariants` and a replay of the events check every settle of every run.
"""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import replace

import pytest
from fakes.event_format import mistake_in
from fakes.lines import Plan, lines
from fakes.plan_runs import (
    NaiveBench,
    ProductBench,
    comparable,
    operate,
    product_cell,
    product_scripts,
    text_of,
)
from fakes.profiles import examples
from fakes.virtual_run import snapshot
from hypothesis import given, note

from bt_orchestrator.model.codec import from_record
from bt_orchestrator.model.fold import apply
from bt_orchestrator.model.state import CellState
from bt_orchestrator.proof.deadlock import deadlock

pytestmark = pytest.mark.timeout(24 * 3600)

DRAWS = (1.0,), (0.0, 7.0, 0.5), (40.0, 0.1, 3.3, 0.0, 12.0)
"""Durations under which a verdict is tried: even, and two sorts of uneven ones."""


def show(plan: Plan) -> None:
    """Print a plan with its failure."""
    note('\n'.join(map(text_of, (plan.cell, *plan.scripts))))
    note(f'{plan.orders} {plan.moments} {plan.seconds}')


def refused(plan: Plan) -> set[str]:
    """Return the scripts that `check` refuses because they get stuck."""
    cell = product_cell(plan)
    scripts = product_scripts(plan, cell)
    return {name for name, script in scripts.items() if deadlock(script) is not None}


def sticks(plan: Plan, script: str, seconds: tuple[float, ...]) -> bool:
    """Tell whether a job of one script gets stuck in the naive cell."""
    orders = (('J', script, 3 * plan.cell['conveyor']['sections']),)
    alone = replace(plan, orders=orders, moments=(), seconds=seconds)
    return not operate(NaiveBench(alone.without_faults()), ())


def test_every_line_goes_as_the_second_opinion_says() -> None:
    """Event for event, whatever fails and whoever answers what."""
    seen: Counter[str] = Counter()

    @examples(80, 2000)
    @given(lines())
    def holds(plan: Plan) -> None:
        show(plan)
        product, naive = ProductBench(plan), NaiveBench(plan)
        ended = operate(product, plan.moments)
        assert operate(naive, plan.moments) == ended
        records = product.run.records
        assert comparable(records) == naive.cell.records
        assert [found for found in map(mistake_in, records) if found] == []
        stuck = refused(plan)
        for script in plan.scripts:
            name = script['script']
            verdicts = [sticks(plan, name, seconds) for seconds in DRAWS]
            assert verdicts == [name in stuck] * len(DRAWS), name
        if not stuck & {script for _, script, _ in plan.orders}:
            assert ended, product.run.waits()
        seen['all'] += 1
        seen['refused'] += bool(stuck)
        seen['two jobs'] += len(plan.orders) > 1
        seen['faults'] += plan.has_faults

    holds()
    assert seen['refused'] >= 0.1 * seen['all'], seen
    assert seen['two jobs'] >= 0.3 * seen['all'], seen
    assert seen['faults'] >= 0.3 * seen['all'], seen


@examples(10, 2000)
@given(lines())
def test_9_1_a_tree_built_anew_after_every_settle_goes_on_the_same(plan: Plan) -> None:
    show(plan)
    one, other = ProductBench(plan), ProductBench(plan, rebuild=True)
    assert operate(one, plan.moments) == operate(other, plan.moments)
    assert one.run.records == other.run.records


@examples(10, 2000)
@given(lines())
def test_9_1_every_prefix_of_the_records_tells_the_state_of_its_moment(plan: Plan) -> None:
    """Written and read, an event changes what it changed when it happened."""
    show(plan)
    bench = ProductBench(plan)
    operate(bench, plan.moments)
    here, read = CellState(bench.cell), CellState(bench.cell)
    for event, record in zip(bench.run.store.read(), bench.run.records, strict=True):
        apply(here, event)
        apply(read, from_record(json.loads(json.dumps(record))))
        assert snapshot(here) == snapshot(read), record
    assert snapshot(here) == snapshot(bench.run.state)
