"""A small cell, and the beginnings of small scripts for it."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

from fakes.action_types import FakeActionTypes

from bt_orchestrator.base.errors import Refused
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.script import Script
from bt_orchestrator.script.cell_file import parse_cell
from bt_orchestrator.script.script_file import parse_script

CELL = """\
cell: test_cell
conveyor:
  sections: 4
  action: /belt/index
  type: bt_orchestrator_interfaces/action/Conveyor
  task: MOVE_ONE_INDEX
components:
  loader: {section: 1, action: /loader/task,
           type: bt_orchestrator_interfaces/action/UnpackingArm, timeout: 60.0}
  camera: {section: 2, action: /camera/task, type: test_interfaces/action/Rich}
  press: {section: 3, action: /press/task, type: bt_orchestrator_interfaces/action/Component}
  table: {section: [2, 3], action: /table/task, type: bt_orchestrator_interfaces/action/Component}
  packer: {section: 4, action: /packer/task, type: bt_orchestrator_interfaces/action/PackingArm}
  lamp: {action: /lamp/task, type: test_interfaces/action/Rich, timeout: none}
  cart: {action: /cart/drive, type: nav_interfaces/action/DriveTo}
"""

LINE = """\
script: test
sections:
  1: [{id: place, task: PLACE_AT_CONVEYOR, action: /loader/task, qty_change: 1}]
  4: [{id: pack, task: PICK_AND_PACK, action: /packer/task, qty_change: -1}]
"""
"""A whole script of four lines; what a test adds begins in line 5, inside `sections`."""


@cache
def cell() -> Cell:
    """Return the small cell."""
    return parse_cell(CELL, 'cell.yaml', FakeActionTypes())


def script(text: str) -> Script:
    """Read a script for the small cell."""
    return parse_script(text, 'script.yaml', cell(), FakeActionTypes())


def line(more: str) -> Script:
    """Read the line with more below it."""
    return script(LINE + more)


def mistakes(read: Callable[[], object]) -> list[str]:
    """Return what reading reports, without the file's name; nothing if it succeeds."""
    try:
        read()
    except Refused as refused:
        return [str(finding).removeprefix(f'{finding.file}:') for finding in refused.findings]
    return []
