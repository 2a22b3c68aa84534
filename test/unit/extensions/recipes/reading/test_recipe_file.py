"""Recipes: operations, their order and their data."""

from __future__ import annotations

from textwrap import indent

import pytest
from fakes.mistake_tables import table
from fakes.recipe_texts import RECIPE, recipe
from fakes.script_texts import mistakes

from bt_orchestrator.model.cell import OnFailure
from bt_orchestrator.model.condition import Condition
from bt_orchestrator.model.limits import OPERATIONS
from bt_orchestrator.model.recipe import Operation, Recipe, Rework
from bt_orchestrator.model.reference import Reference, Template


def with_operations(text: str) -> Recipe:
    return recipe(RECIPE.format(indent(text, '  ')))


def result(operation: str, name: str) -> Template:
    return Template((Reference('results', operation, (name,)),))


@pytest.mark.parametrize(('text', 'expected'), table('recipes'))
def test_recipes(text: str, expected: list[str]) -> None:
    assert mistakes(lambda: recipe(text)) == expected


@pytest.mark.parametrize(('text', 'expected'), table('operations'))
def test_operations(text: str, expected: list[str]) -> None:
    assert mistakes(lambda: with_operations(text)) == expected


def test_the_head_of_a_recipe_is_read() -> None:
    read = with_operations('- {id: fix, do: tape}')
    assert (read.name, read.version, read.script) == ('P-1', 2, 'p_one')
    assert list(read.params) == ['n', 's', 'x']
    assert list(read.by_id) == ['place', 'fix', 'pack']


def test_an_operation_comes_after_the_one_above() -> None:
    read = with_operations('- {id: fix, do: tape}\n- {id: first, do: tape, after: []}')
    after = {operation.id: operation.after for operation in read.operations}
    assert after == {'place': (), 'fix': ('place',), 'first': (), 'pack': ('first',)}


def test_operation_is_read_with_all_options() -> None:
    read = with_operations(
        '- {id: locate, do: locate}\n'
        '- {id: press, do: [press, tape], after: [place, locate], needs: {size: locate},\n'
        '   retries: 2, on_failure: reject, unless: "${results.locate.seen}"}\n'
        '- {id: fix, do: glue, parameters: {amount: 2, text: "${params.s}"}}'
    )
    assert read.by_id['press'] == Operation(
        'press',
        ('press', 'tape'),
        ('place', 'locate'),
        needs={'size': 'locate'},
        options={
            'retries': 2,
            'on_failure': OnFailure.REJECT,
            'condition': Condition(result('locate', 'seen'), negated=True),
        },
    )
    assert read.by_id['fix'].parameters == {
        'amount': 2.0,
        'text': Template((Reference('params', 's'),)),
    }


def test_serial_and_lots_of_item_are_read() -> None:
    text = RECIPE.format('  - {id: look, do: locate, identifies: text}')
    read = recipe(text.replace('operations:', 'lots: {glue: "${params.s}"}\noperations:'))
    assert read.by_id['look'].options == {'identifies': ('text',)}
    assert read.lots == {'glue': Template((Reference('params', 's'),))}


def test_what_is_repeated_is_in_order() -> None:
    read = with_operations(
        '- repeat:\n'
        '    - {id: fix, do: tape}\n'
        '    - {id: look, do: look, after: place, fails_unless: "${results.look.seen}"}\n'
        '  times: 3'
    )
    assert read.reworks == (Rework(('fix', 'look'), 3),)
    assert read.by_id['look'].after == ('fix', 'place')
    assert read.by_id['look'].options == {'fails_unless': Condition(result('look', 'seen'))}
    assert read.by_id['pack'].after == ('look',)


def test_a_recipe_has_a_largest_number_of_operations() -> None:
    def steps(number: int) -> str:
        return '\n'.join(f'- {{id: s{n}, do: tape}}' for n in range(number))

    assert len(with_operations(steps(OPERATIONS - 2)).operations) == OPERATIONS
    errors = mistakes(lambda: with_operations(steps(OPERATIONS + 1)))
    what = f'the recipe has more than {OPERATIONS} operations; make two recipes of it'
    assert errors == [f'{OPERATIONS + 6}:5: {what}']
