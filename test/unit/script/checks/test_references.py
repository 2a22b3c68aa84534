"""References: syntax, when a value exists, and of which type it is."""

from __future__ import annotations

import pytest
from fakes.mistake_tables import table
from fakes.mistake_texts import REFERENCE
from fakes.script_texts import line, mistakes

from bt_orchestrator.model.reference import Reference, Template


@pytest.mark.parametrize(('argument', 'expected'), table('references'))
def test_references(argument: str, expected: list[str]) -> None:
    assert mistakes(lambda: line(REFERENCE.format(argument))) == expected


@pytest.mark.parametrize(('text', 'expected'), table('reference_order'))
def test_value_must_precede_its_use_and_fit(text: str, expected: list[str]) -> None:
    assert mistakes(lambda: line(text)) == expected


def test_references_become_templates() -> None:
    read = line(
        REFERENCE.format(
            'special_argument_1: "lot ${params.lot}: ${item.number}", '
            'special_argument_2: "${results.look.value}"'
        )
    )
    assert read.tasks['use'].args == {
        'special_argument_1': Template(
            ('lot ', Reference('params', 'lot'), ': ', Reference('item', 'number'))
        ),
        'special_argument_2': Template((Reference('results', 'look', ('value',)),)),
    }


def test_the_longest_id_that_fits_is_meant() -> None:
    read = line(
        '  2: [{id: a, task: RUN, action: /camera/task}, '
        '{id: a.pose, task: RUN, action: /camera/task},\n'
        '    {id: c, task: RUN, action: /camera/task, args: {name: "${results.a.pose.code}"}}]\n'
    )
    assert read.tasks['c'].args['name'] == Template((Reference('results', 'a.pose', ('code',)),))


def test_nested_fields_are_a_path() -> None:
    read = line(REFERENCE.format('special_argument_1: "${results.look.pose.frame}"'))
    assert read.tasks['use'].args['special_argument_1'] == Template(
        (Reference('results', 'look', ('pose', 'frame')),)
    )
