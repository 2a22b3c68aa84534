"""Cell files."""

from __future__ import annotations

from pathlib import Path

import pytest
from fakes.action_types import FakeActionTypes
from fakes.mistake_tables import table
from fakes.script_texts import CELL, cell, mistakes

from bt_orchestrator.base.errors import Refused
from bt_orchestrator.model.cell import CONVEYOR, MOST_ITEMS, Cell, OnFailure, Start, StateTopic
from bt_orchestrator.model.codec import digest
from bt_orchestrator.script.cell_file import parse_cell, read_cell

ROOT = Path(__file__).parents[3]


def parsed(text: str) -> Cell:
    return parse_cell(text, 'cell.yaml', FakeActionTypes())


@pytest.mark.parametrize(('text', 'expected'), table('cells'))
def test_cells(text: str, expected: list[str]) -> None:
    assert mistakes(lambda: parsed(text)) == expected


def test_the_shipped_cell_is_read() -> None:
    shipped = read_cell(ROOT / 'config' / 'reference_cell.yaml', FakeActionTypes())
    assert (shipped.name, shipped.conveyor.sections) == ('reference_cell', 5)
    assert shipped.conveyor.task == 'MOVE_ONE_INDEX'
    assert shipped.conveyor.component.timeout_s == 30.0
    assert shipped.conveyor.component.duration_s('HOME') == 2.0
    arm = shipped.components['unpacking_arm']
    assert (arm.sections, arm.timeout_s, arm.duration_s('PICK_FROM_CASE')) == ((1,), 60.0, 1.5)
    assert arm.state == StateTopic('/unpacking/state', 'std_msgs/msg/String', 'data', ('READY',))
    assert shipped.components['component_1a'].timeout_s == 300.0


def test_the_conveyor_is_the_first_component() -> None:
    belt = cell().conveyor
    assert next(iter(cell().components)) == CONVEYOR
    assert cell().components[CONVEYOR] is belt.component
    assert (belt.retries, belt.on_failure) == (0, OnFailure.HOLD)
    assert belt.component.sections == ()


def test_components_are_read() -> None:
    components = cell().components
    assert components['table'].sections == (2, 3)
    assert components['lamp'].sections == ()
    assert components['lamp'].timeout_s is None
    assert components['press'].action == '/press/task'
    assert cell().by_action('/press/task') is components['press']


def test_sections_are_ascending() -> None:
    assert parsed(CELL.replace('[2, 3]', '[3, 2]')).components['table'].sections == (2, 3)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(Refused, match='the file does not exist'):
        read_cell(tmp_path / 'cell.yaml', FakeActionTypes())


def test_start_is_binding_unless_cell_makes_it_advisory() -> None:
    assert cell().start is Start.BINDING
    assert parsed(f'{CELL}\nstart: advisory\n').start is Start.ADVISORY
    findings = mistakes(lambda: parsed(f'{CELL}\nstart: maybe\n'))
    assert len(findings) == 1
    assert 'binding' in findings[0]


def test_order_item_limit_does_not_change_digest() -> None:
    more = parsed(f'{CELL}\nmost_items: 50000\n')
    assert (cell().most_items, more.most_items) == (MOST_ITEMS, 50_000)
    assert digest(more) == digest(cell()), 'releases are for a digest, and no goal changes'
    assert len(mistakes(lambda: parsed(f'{CELL}\nmost_items: 0\n'))) == 1
