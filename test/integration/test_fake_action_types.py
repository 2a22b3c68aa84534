"""The fake describes the example interfaces as the installed packages do."""

from __future__ import annotations

from pathlib import Path

import pytest
from fakes.action_types import ACTIONS, MESSAGES, PACKAGE, FakeActionTypes

from bt_orchestrator.ros.types.action_types import InstalledActionTypes
from bt_orchestrator.script.cell_file import read_cell
from bt_orchestrator.script.field_types import simple_type
from bt_orchestrator.script.script_file import read_script

ROOT = Path(__file__).parents[2]
EXAMPLES = [action.name for action in ACTIONS if action.name.startswith(PACKAGE)]


@pytest.mark.parametrize('name', EXAMPLES)
def test_the_example_actions_are_described_alike(name: str) -> None:
    fake, real = FakeActionTypes().action(name), InstalledActionTypes().action(name)
    assert fake == real


@pytest.mark.parametrize(
    ('message', 'field'), [(name, field) for name in MESSAGES for field in MESSAGES[name]]
)
def test_the_example_messages_are_described_alike(message: str, field: str) -> None:
    fake = FakeActionTypes().message_field(message, field)
    real = InstalledActionTypes().message_field(message, field)
    assert simple_type(fake) == simple_type(real)


@pytest.mark.parametrize(
    'script', ['trees/reference_process.yaml', 'trees/inspect_and_assemble.yaml']
)
def test_the_shipped_files_fit_the_installed_types(script: str) -> None:
    types = InstalledActionTypes()
    cell = read_cell(ROOT / 'config' / 'reference_cell.yaml', types)
    assert read_script(ROOT / script, cell, types).name == Path(script).stem
