"""Names of tasks, from the values that goals carry."""

from __future__ import annotations

from typing import Any

from bt_orchestrator.model.action_type import ActionType, FieldType, MessageType
from bt_orchestrator.model.cell import Component
from bt_orchestrator.sim.controllers.component_server import TaskNames


def names(
    constants: dict[str, Any], durations: dict[str, float], has_task: bool = True
) -> TaskNames:
    fields = {'task': FieldType('int', 'uint8')} if has_task else {}
    action_type = ActionType(
        'p/action/T', MessageType('G', fields), MessageType('R', {}), constants
    )
    return TaskNames(Component('c', (), 'c', 'p/action/T', durations_s=durations), action_type)


def test_a_value_is_named_by_its_constant() -> None:
    assert names({'A': 0, 'B': 1}, {}).name(1) == 'B'


def test_a_value_without_constant_has_no_name() -> None:
    assert names({'A': 0}, {}).name(7) is None


def test_cell_file_chooses_between_equal_constants() -> None:
    constants = {'MODE_FAST': 1, 'A': 1, 'MODE_SLOW': 2}

    assert names(constants, {'A': 2.0}).name(1) == 'A'
    assert names(constants, {}).name(1) == 'MODE_FAST'


def test_a_task_field_without_constants_takes_any_value() -> None:
    assert names({}, {}).name('grind') == 'grind'


def test_type_without_task_field_uses_cell_file_label() -> None:
    assert names({}, {'COUNT': 2.0}, has_task=False).name(None) == 'COUNT'
    assert names({}, {'COUNT': 2.0, 'STOP': 1.0}, has_task=False).name(None) == ''
