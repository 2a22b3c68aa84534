"""Setups in a cell file, and in the text of a script."""

from __future__ import annotations

import pytest
from fakes.action_types import FakeActionTypes
from fakes.line import Line, with_section
from fakes.mistake_tables import table
from fakes.mistake_texts import COMPONENT, NAMED
from fakes.script_texts import mistakes

from bt_orchestrator.base.errors import Refused
from bt_orchestrator.model.cell import Cell, Setup
from bt_orchestrator.model.codec import digest, from_plain, to_plain
from bt_orchestrator.model.script import Script
from bt_orchestrator.script.cell_file import parse_cell
from bt_orchestrator.script.script_file import parse_script
from bt_orchestrator.script.writing.script_text import write_script

GRIPPER = (
    'setups: {gripper: [small, large]}, '
    'changes: {gripper: {task: TASK_C, argument: special_argument_1}}'
)
SMALL = with_section(2, '- {id: work, @a2, setup: {gripper: small}}')


def parsed(text: str) -> Cell:
    return parse_cell(text, 'cell.yaml', FakeActionTypes())


@pytest.mark.parametrize(('options', 'expected'), table('setups'))
def test_mistakes(options: str, expected: list[str]) -> None:
    assert mistakes(lambda: parsed(COMPONENT.format(NAMED + options))) == expected


def test_setup_values_are_names_with_typed_arguments() -> None:
    text = 'setups: {program: [1, 2]}, changes: {program: {task: RUN, argument: count}}'
    arm = parsed(COMPONENT.format(NAMED + text)).components['arm']
    assert arm.setups == {'program': Setup({'1': 1, '2': 2}, 'RUN', 'count')}


def test_cell_with_setups_round_trips_through_its_record() -> None:
    cell = Line(keys={'a2': GRIPPER}).cell
    assert from_plain(Cell, to_plain(cell)) == cell


@pytest.mark.parametrize(
    ('task', 'expected'),
    [
        ('@a2, setup: {gripper: lrge}', 'the setup `gripper` of `a2` cannot be `lrge`'),
        ('@a2, setup: {grip: large}', '`a2` has no setup `grip`; did you mean `gripper`?'),
        ('@a2, setup: large', '`setup` must be a mapping, not the text `large`'),
        ('@b2, setup: {gripper: large}', '`b2` has no setup `gripper`'),
        ('@a2.TASK_C, runs_for: all', '`work` changes the setup `gripper`, so its new value'),
        (
            '@a2.TASK_C, runs_for: all, args: {special_argument_1: "${order.id}"}',
            'so its new value must be known',
        ),
        (
            '@a2.TASK_C, runs_for: all, args: {special_argument_1: small}, when: "${results.x.y}"',
            'so it must run for every item; remove `when`',
        ),
    ],
)
def test_mistakes_of_a_task(task: str, expected: str) -> None:
    with pytest.raises(Refused) as refused:
        Line(keys={'a2': GRIPPER}).script(with_section(2, f'- {{id: work, {task}}}'))
    assert expected in str(refused.value)


def test_a_change_cannot_be_repeated() -> None:
    text = """
    - repeat:
      - {id: to_small, @a2.TASK_C, args: {special_argument_1: small}, runs_for: all}
      - {id: look, @a2, fails_unless: "${results.look.item_present}"}
    """
    with pytest.raises(Refused, match='`to_small` changes a setup, and cannot be repeated'):
        Line(keys={'a2': GRIPPER}).script(with_section(2, text))


def test_an_id_of_an_implied_change_is_taken() -> None:
    text = SMALL.replace('id: pack', 'id: a2.gripper.small')
    with pytest.raises(Refused, match='is the id of a change that this script implies'):
        Line(keys={'a2': GRIPPER}).script(text)


def test_initialization_asks_for_no_setup() -> None:
    text = 'initialization: [{id: ready, @a2.PREPARE, setup: {gripper: small}}]' + SMALL
    with pytest.raises(Refused, match='initialization asks for no setup'):
        Line(keys={'a2': GRIPPER}).script(text)


def test_implied_changes_are_omitted_from_text_and_restored() -> None:
    line = Line(keys={'a2': GRIPPER})
    script = line.script('initialization: [{id: ready, @a2.PREPARE}]' + SMALL)
    assert [task.id for task in script.initialization] == ['ready', 'a2.gripper.small']
    text = write_script(script, line.cell)
    assert 'a2.gripper.small' not in text
    again = parse_script(text, 'again.yaml', line.cell, FakeActionTypes())
    assert digest(again) == digest(script)
    assert from_plain(Script, to_plain(script)) == script
