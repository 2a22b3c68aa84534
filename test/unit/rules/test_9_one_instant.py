"""What several servers say at one instant is on record in the order in which they say it."""

from __future__ import annotations

from typing import Any

import pytest
from fakes.drawn.plan import Order, Plan
from fakes.plan_operator import operate
from fakes.plan_runs import NaiveBench, ProductBench, comparable

TYPE = 'bt_orchestrator_interfaces/action/'
BELT = {
    'sections': 2,
    'action': '/belt/do',
    'type': TYPE + 'Conveyor',
    'task': 'MOVE_ONE_INDEX',
    'duration': 2.0,
}


def device(name: str, section: int, seconds: float, fault: str = '') -> dict[str, Any]:
    given = {'action': f'/{name}/do', 'type': TYPE + 'Component', 'section': section}
    return {**given, 'durations': {'TASK_A': seconds}, 'faults': [fault] if fault else []}


def task(id_: str, by: str, **more: Any) -> dict[str, Any]:
    return {'id': id_, 'task': 'TASK_A', 'action': f'/{by}/do', **more}


PLACE = task('place', 'arm', qty_change=1)


def plan(*sent: str, failing: str = '#1=abort', long_timeout: float = 300.0) -> Plan:
    """Return a line on which a task fails, a second after the item was placed: its job is aborted.

    :param sent: faults of components with a task that begins at that time
    """
    others = [f'b{n}' for n in range(len(sent))]
    components = {
        'arm': device('arm', 1, 1.0),
        'long': device('long', 1, 3.0),
        'bad': device('bad', 1, 1.0, failing),
        **{name: device(name, 1, 1.0, fault) for name, fault in zip(others, sent, strict=True)},
        'out': device('out', 2, 1.0),
    }
    members = [[task(f'first_{name}', name), task(f'second_{name}', name)] for name in others]
    group = [
        *members,
        task('long', 'long', timeout=long_timeout),
        task('bad', 'bad', on_failure='abort_job'),
    ]
    lists = {
        1: [PLACE, {'parallel': group}],
        2: [task('pack', 'out', qty_change=-1, runs_for='all')],
    }
    cell = {'cell': 'one_instant', 'conveyor': BELT, 'components': components}
    script = {'script': 'script', 'sections': lists}
    return Plan(cell, (script,), (Order('J', 'script', 1),), (), (), (), frozenset())


@pytest.mark.parametrize(
    ('sent', 'ends'),
    [
        ([''], ['long', 'second_b0']),
        (['', ''], ['long', 'second_b0', 'second_b1']),
        (['#2=reject'], ['second_b0', 'long']),
        (['', '#2=reject'], ['second_b1', 'long', 'second_b0']),
    ],
)
def test_9_1_cancel_waits_only_for_goal_acceptance(sent: list[str], ends: list[str]) -> None:
    """A goal that is on its way is answered at once, or accepted and then cancelled (2.4)."""
    line = plan(*sent)
    product = ProductBench(line)
    assert operate(product, ())
    assert [name for name in product.run.order('task.failed') if name != 'bad'] == ends
    naive = NaiveBench(line)
    assert operate(naive, ())
    assert naive.cell.records == comparable(product.run.records)


def test_9_1_timely_end_precedes_time_limit() -> None:
    line = plan(failing='', long_timeout=3.0)
    product = ProductBench(line)
    assert operate(product, ())
    assert product.run.all('task.cancel_requested') == []
    naive = NaiveBench(line)
    assert operate(naive, ())
    assert naive.cell.records == comparable(product.run.records)
