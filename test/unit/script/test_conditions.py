"""`when` and `unless`."""

from __future__ import annotations

import pytest
from fakes.mistake_tables import table
from fakes.mistake_texts import CONDITION
from fakes.script_texts import line, mistakes

from bt_orchestrator.model.reference import Reference, Template
from bt_orchestrator.model.script import Condition


@pytest.mark.parametrize(('condition', 'expected'), table('conditions'))
def test_conditions(condition: str, expected: list[str]) -> None:
    assert mistakes(lambda: line(CONDITION.format(condition))) == expected


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
    read = line(CONDITION.format(text)).tasks['2.2'].condition
    assert read == Condition(template, equals, negated)
