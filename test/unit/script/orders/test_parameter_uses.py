"""Values of an order against the goal fields that they go into."""

from __future__ import annotations

import pytest
from fakes.action_types import FakeActionTypes
from fakes.script_texts import cell, line

from bt_orchestrator.base.errors import UnknownActionType
from bt_orchestrator.script.orders.parameter_uses import action_types, misfitting_uses

TYPES = action_types(cell(), FakeActionTypes())


@pytest.mark.parametrize(
    ('argument', 'paths'),
    [
        ('code: "${params.a}"', [('params', 'a')]),
        ('name: "${params.a}"', []),
        ('code: "${order.id}"', [('order',)]),
        ('small: "${order.quantity}"', [('quantity',)]),
        ('count: "${order.quantity}"', []),
        ('names: ["${params.a}"]', []),
        ('few: ["${order.quantity}", "${order.quantity}"]', [('quantity',)] * 2),
        ('pose: {frame: "${params.a}"}', []),
        ('name: "x ${params.a}"', []),
        ('small: "${item.number}"', []),
    ],
)
def test_uses(argument: str, paths: list[tuple[str, ...]]) -> None:
    script = line(
        f'  2: [{{task: RUN, action: /camera/task, args: {{{argument}}}}}]\n'
        'params: {a: {type: str}}\n'
    )
    uses = misfitting_uses(script, 'WO-1', 300, {'a': 'long'}, TYPES)
    assert [use.path for use in uses] == paths


def test_initialization_is_checked_too() -> None:
    script = line(
        'initialization: [{task: RUN, action: /lamp/task, args: {code: "${params.a}"}}]\n'
        'params: {a: {type: str}}\n'
    )
    (use,) = misfitting_uses(script, 'WO-1', 1, {'a': 'long'}, TYPES)
    assert use.what.endswith('for `code` of the task `init.1`, not the text `long`')


def test_a_missing_package_is_told() -> None:
    with pytest.raises(UnknownActionType, match='nav_interfaces is not installed'):
        action_types(cell(), FakeActionTypes(without='nav_interfaces'))


BOUNDED = """\
  2: [{{id: look, task: RUN, action: /camera/task}}]
  3: [{{task: TASK_A, action: /press/task, when: {{value: "${{{}}}", {}}}}}]
params: {{low: {{type: int}}, high: {{type: int}}, x: {{type: float}}, y: {{type: float}}}}
"""
TOO_LARGE = (
    '`params.low` must be a whole number from -2147483648 to 2147483647 (int32) '
    'in a condition of the task `3.1`, not the number 2147483648'
)
AT_LOW, BETWEEN = 'at_least: "${params.low}"', 'between: ["${params.low}", "${params.high}"]'


@pytest.mark.parametrize(
    ('value', 'comparison', 'params', 'expected'),
    [
        ('results.look.count', AT_LOW, {'low': 7}, []),
        (
            'results.look.count',
            AT_LOW,
            {'low': 2**31},
            [TOO_LARGE],
        ),
        ('results.look.pose.position.x', 'at_most: "${params.x}"', {'x': 2.5}, []),
        ('results.look.value', BETWEEN, {'low': 3, 'high': 3}, []),
        (
            'results.look.value',
            BETWEEN,
            {'low': 4, 'high': 3},
            ['no value is between 4 and 3 in a condition of the task `3.1`'],
        ),
        (
            'results.look.value',
            'between: [1.5, "${params.x}"]',
            {'x': 1.25},
            ['no value is between 1.5 and 1.25 in a condition of the task `3.1`'],
        ),
        ('params.y', 'between: ["${params.x}", 9]', {'x': 1.25, 'y': 99.0}, []),
        ('item.number', AT_LOW, {'low': None}, []),
        ('params.high', BETWEEN, {'low': 4, 'high': None}, []),
    ],
)
def test_bounds_of_an_order(
    value: str, comparison: str, params: dict[str, object], expected: list[str]
) -> None:
    script = line(BOUNDED.format(value, comparison))
    uses = misfitting_uses(script, 'WO-1', 1, params, TYPES)
    assert [use.what for use in uses] == expected
