"""A small cell that can do something, and the beginnings of recipes and overrides for it."""

from __future__ import annotations

from functools import cache

from fakes.action_types import FakeActionTypes

from bt_orchestrator.extensions.recipes.reading.overrides_file import parse_overrides
from bt_orchestrator.extensions.recipes.reading.recipe_file import parse_recipe
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.recipe import Overrides, Recipe
from bt_orchestrator.script.cell_file import parse_cell

CELL = """\
cell: able_cell
conveyor:
  sections: 4
  action: /belt/index
  type: bt_orchestrator_interfaces/action/Conveyor
  task: MOVE_ONE_INDEX
  prepare: {id: home_belt, task: HOME, once: true}
components:
  loader:
    section: 1
    action: /loader/task
    type: bt_orchestrator_interfaces/action/UnpackingArm
    prepare: {id: ready_loader, task: PREPARE, after: conveyor}
    capabilities:
      fetch: {task: PICK_FROM_CASE, requires_conveyor: false}
      put: {task: PLACE_AT_CONVEYOR, qty_change: 1}
  camera:
    section: 2
    action: /camera/task
    type: test_interfaces/action/Rich
    capabilities:
      locate: {task: RUN, gives: {pose: pose, size: value, text: code, seen: ok}}
      bore: {task: STOP, gives: {text: code}, holds: {depth: 1}}
      mark: {task: RUN, args: {name: "item ${item.number}"}, parameters: {text: name, at: pose},
             gives: {size: code}}
      gauge: {task: STOP, gives: {depth: value}, holds: {size: 1}}
      scan: {task: RUN, identifies: pose.frame}
  press:
    section: 3
    action: /press/task
    type: bt_orchestrator_interfaces/action/Component
    capabilities:
      glue: {task: TASK_A, parameters: {amount: special_argument_2}}
      insert: {task: TASK_B, needs: {size: special_argument_2, depth: none}}
      look: {task: TASK_C, gives: {seen: item_present, size: measurement}}
  table:
    section: [2, 3]
    workspaces: [table]
    action: /table/task
    type: bt_orchestrator_interfaces/action/Component
    capabilities:
      glue: {task: TASK_A, parameters: {amount: special_argument_2, text: special_argument_1}}
      tape: {task: TASK_B}
      press: {task: TASK_C, needs: {size: special_argument_2}, on_failure: continue}
  packer:
    section: 4
    action: /packer/task
    type: bt_orchestrator_interfaces/action/PackingArm
    capabilities:
      take: {task: PICK_AND_PACK, qty_change: -1}
"""

HEAD = """\
recipe: P-1
version: 2
script: p_one
"""

ENDS = """\
  - {{id: place, do: put}}
{}
  - {{id: pack, do: take}}
"""
"""Operations around those of a test, which begin in line 7 of a recipe."""

RECIPE = f"""\
{HEAD}params: {{{{n: {{{{type: int}}}}, s: {{{{type: str}}}}, x: {{{{type: float}}}}}}}}
operations:
{ENDS}"""
"""A recipe with parameters, and a place for operations."""

OVERRIDDEN = RECIPE.format('  - {id: stick, do: [tape, glue], parameters: {amount: 1, text: a}}')


@cache
def able_cell() -> Cell:
    """Return the small cell."""
    return parse_cell(CELL, 'cell.yaml', FakeActionTypes())


def recipe(text: str) -> Recipe:
    """Read a recipe for the small cell."""
    return parse_recipe(text, 'recipe.yaml', able_cell(), FakeActionTypes())


def overrides(text: str) -> Overrides:
    """Read overrides for a recipe of three operations."""
    return parse_overrides(text, 'overrides.yaml', recipe(OVERRIDDEN), able_cell())
