"""`when` and `unless`."""

from __future__ import annotations

from typing import Any

import pytest
from fakes.mistake_tables import table
from fakes.mistake_texts import AROUND, CONDITION, VERDICT
from fakes.script_texts import line, mistakes, script

from bt_orchestrator.model.condition import Condition
from bt_orchestrator.model.reference import Reference, Template


@pytest.mark.parametrize(('condition', 'expected'), table('conditions'))
def test_conditions(condition: str, expected: list[str]) -> None:
    assert mistakes(lambda: line(CONDITION.format(condition))) == expected


@pytest.mark.parametrize(('lots', 'expected'), table('lots'))
def test_lots(lots: str, expected: list[str]) -> None:
    assert mistakes(lambda: script(AROUND['lots'].whole(lots))) == expected


@pytest.mark.parametrize(('likely', 'expected'), table('likely'))
def test_what_is_likely(likely: str, expected: list[str]) -> None:
    assert mistakes(lambda: line(CONDITION.format(likely))) == expected


@pytest.mark.parametrize(('verdict', 'expected'), table('verdicts'))
def test_verdicts(verdict: str, expected: list[str]) -> None:
    assert mistakes(lambda: line(VERDICT.format(verdict))) == expected


@pytest.mark.parametrize(
    ('text', 'name', 'equals', 'negated'),
    [
        ('when: "${params.b}"', 'b', True, False),
        ('unless: "${params.b}"', 'b', True, True),
        ('when: {value: "${params.n}", equals: 3}', 'n', 3, False),
        ('unless: {value: "${params.s}", equals: "3"}', 's', '3', True),
    ],
)
def test_a_condition_is_read(text: str, name: str, equals: object, negated: bool) -> None:
    template = Template((Reference('params', name),))
    assert read(text) == Condition(template, equals, negated)


def read(text: str) -> Condition | None:
    return line(CONDITION.format(text)).tasks['2.2'].condition


def named(name: str) -> Template:
    return Template((Reference('params', name),))


@pytest.mark.parametrize(
    ('comparison', 'operands', 'words'),
    [
        ('not_equals: 3', {'not_equals': 3}, 'is not 3'),
        ('at_least: 0', {'at_least': 0}, 'at least 0'),
        ('at_most: "${params.n}"', {'at_most': named('n')}, 'at most ${params.n}'),
        ('between: [0, 3]', {'at_least': 0, 'at_most': 3}, 'from 0 to 3'),
        ('one_of: [1, 2]', {'one_of': (1, 2)}, 'one of 1, 2'),
    ],
)
def test_a_comparison_is_read(comparison: str, operands: dict[str, Any], words: str) -> None:
    condition = read(f'when: {{value: "${{params.n}}", {comparison}}}')
    assert condition == Condition(named('n'), **operands)
    assert str(condition) == f'when ${{params.n}} {words}'


def test_conditions_of_conditions_are_read() -> None:
    n = '{value: "${params.n}", equals: 3}'
    condition = read(f'unless: {{any: ["${{params.b}}", {{all: ["${{params.b}}", {n}]}}]}}')
    both = Condition(all=(Condition(named('b')), Condition(named('n'), 3)))
    assert condition == Condition(any=(Condition(named('b')), both), negated=True)
    assert str(condition) == 'unless ${params.b} or (${params.b} and ${params.n} = 3)'
