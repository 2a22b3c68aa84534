"""Values of an order against the goal fields that they go into."""

from __future__ import annotations

import pytest
from fakes.action_types import FakeActionTypes
from fakes.script_texts import cell, line

from bt_orchestrator.errors import UnknownActionType
from bt_orchestrator.script.parameter_uses import action_types, misfitting_uses

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
