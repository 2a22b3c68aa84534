"""A value that is or contains no finite number is no value (semantics 6.3)."""

from __future__ import annotations

from math import inf, nan
from typing import Any

import pytest
from fakes.line import Line

from bt_orchestrator.base.errors import MissingResult
from bt_orchestrator.model.reference import Reference, Scope, look_up

POSE = {'position': {'x': 1.0, 'y': nan}, 'frame': 'belt'}


def named(value: Any, *fields: str) -> Any:
    scope = Scope({}, {}, {}, {'look': {'found': value}})
    return look_up(Reference('results', 'look', ('found', *fields)), scope)


@pytest.mark.parametrize(
    ('value', 'where'),
    [
        (nan, 'is nan'),
        (-inf, 'is -inf'),
        (POSE, 'has nan at position.y'),
        ([1.0, 2.0, inf], 'has inf at [2]'),
        ([POSE, POSE], 'has nan at [0].position.y'),
        ({'poses': [{'x': 0.5}, {'x': -inf}]}, 'has -inf at poses[1].x'),
    ],
)
def test_6_3_what_is_no_finite_number_is_no_value(value: Any, where: str) -> None:
    with pytest.raises(MissingResult) as missing:
        named(value)
    expected = f'${{results.look.found}} {where}, which is no finite number'
    assert str(missing.value) == expected


@pytest.mark.parametrize('value', [1.5, 3, True, 'nan', b'', [], [1.0, 2], {'x': [[1e300]]}])
def test_6_3_finite_values_are_named_as_they_are(value: Any) -> None:
    assert named(value) is value


def test_6_3_only_what_is_named_counts() -> None:
    assert named(POSE, 'position', 'x') == 1.0
    assert named(POSE, 'frame') == 'belt'


USED = """
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2: [{id: look, @a2}]
  3: [{id: use, @a3, HOW}, {id: pack, @b3, qty_change: -1}]
"""


def used(how: str) -> str:
    return USED.replace('HOW', how)


@pytest.mark.parametrize('value', [nan, inf, -inf])
@pytest.mark.parametrize(
    'argument',
    [
        'special_argument_2: "${results.look.measurement}"',
        'special_argument_1: "at ${results.look.measurement}"',
    ],
)
def test_6_3_goal_never_has_non_finite_argument(argument: str, value: float) -> None:
    run = Line(results={'a2': {'measurement': value}}).run(used(f'args: {{{argument}}}'))
    assert run.reasons() == ['missing_result']
    assert run.starts('use') == []
    (hold,) = run.state.holds.values()
    assert hold.message == f'${{results.look.measurement}} is {value}, which is no finite number'


def test_2_8_non_finite_value_in_verdict_prevents_goal() -> None:
    other = '{value: "${results.look.measurement}", at_least: 0}'
    verdict = f'{{all: ["${{results.use.item_present}}", {other}]}}'
    run = Line(results={'a2': {'measurement': nan}}).run(used(f'fails_unless: {verdict}'))
    assert run.reasons() == ['missing_result']
    assert run.starts('use') == []
