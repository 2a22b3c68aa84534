"""Whole scripts."""

from __future__ import annotations

from pathlib import Path

import pytest
from fakes.action_types import FakeActionTypes
from fakes.mistake_tables import table
from fakes.script_texts import cell, line, mistakes, script

from bt_orchestrator.base.errors import Refused
from bt_orchestrator.model.cell import OnFailure
from bt_orchestrator.model.script import Dependency, RunsFor, Script, Zone
from bt_orchestrator.script.cell_file import read_cell
from bt_orchestrator.script.script_file import read_script

ROOT = Path(__file__).parents[3]


def shipped(path: str) -> Script:
    types = FakeActionTypes()
    reference_cell = read_cell(ROOT / 'config' / 'reference_cell.yaml', types)
    return read_script(ROOT / path, reference_cell, types)


@pytest.mark.parametrize(('text', 'expected'), table('scripts'))
def test_scripts(text: str, expected: list[str]) -> None:
    assert mistakes(lambda: script(text)) == expected


def test_the_script_of_the_deck_is_read() -> None:
    read = shipped('trees/reference_process.yaml')
    assert (read.name, read.source, read.sink, read.quantity) == ('reference_process', 1, 5, None)
    assert [*read.tasks][3:8] == ['pick', 'place', '2.1', '3.1', '4.1']
    assert read.tasks['pick'].retries == 2
    assert not read.tasks['pick'].requires_conveyor
    assert read.tasks['3.1'].on_failure is OnFailure.CONTINUE
    assert str(read.tasks['4.2'].args['special_argument_1']) == '${params.label}'
    assert read.tasks['home_belt'].once
    assert read.tasks['pack'].timeout_s == 300.0
    assert read.tasks['pick'].timeout_s == 60.0


def test_the_script_with_flags_and_rejects_is_read() -> None:
    read = shipped('trees/inspect_and_assemble.yaml')
    assert read.dependencies == (Dependency('camera_read', 'inspect', 'assemble'),)
    assert read.zones == (Zone('shared_table', ('assemble', 'mark')),)
    assert read.tasks['inspect'].on_failure is OnFailure.REJECT
    assert read.tasks['pack'].runs_for is RunsFor.ALL
    assert str(read.tasks['seal'].condition) == 'when ${results.weigh.item_present}'
    assert read.sections[4].steps[0].is_group


def test_stuck_script_has_no_static_mistake() -> None:
    assert shipped('test/data/stuck.yaml').name == 'stuck'


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(Refused, match='the file does not exist'):
        read_script(tmp_path / 'a.yaml', cell(), FakeActionTypes())


def test_a_script_may_have_a_default_quantity() -> None:
    assert line('quantity: 12\n').quantity == 12


def test_aliases_are_read_like_what_they_stand_for() -> None:
    read = line(
        '  2: [&look {id: a, task: RUN, action: /camera/task, retries: 3},\n'
        '    {<<: *look, id: b, task: STOP}]\n'
    )
    assert (read.tasks['b'].retries, read.tasks['b'].name) == (3, 'STOP')
