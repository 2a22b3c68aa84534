"""Texts read as one of the kinds of files, and what a refusal has to say."""

from __future__ import annotations

import re
from functools import cache

from fakes.action_types import FakeActionTypes
from fakes.shipped import REFERENCE_CELL, ROOT

from bt_orchestrator.base.errors import Refused
from bt_orchestrator.extensions.recipes.reading.overrides_file import parse_overrides
from bt_orchestrator.extensions.recipes.reading.recipe_file import parse_recipe, read_recipe
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.recipe import Recipe
from bt_orchestrator.model.script import Script
from bt_orchestrator.script.cell_file import parse_cell, read_cell
from bt_orchestrator.script.orders.order_file import bind_order, parse_order
from bt_orchestrator.script.script_file import parse_script, read_script

SCRIPTS = (
    'trees/reference_process.yaml',
    'trees/inspect_and_assemble.yaml',
    'test/data/stuck.yaml',
)
ABLE_CELL = 'config/cell_with_capabilities.yaml'
OVERRIDES = 'recipes/wm_100.overrides.yaml'
ORDER = 'config/orders/wo_1001.yaml'
RECIPE = 'recipes/wm_100.yaml'
KINDS = (ABLE_CELL, SCRIPTS[0], ORDER, RECIPE, OVERRIDES)
"""One file of each kind."""

FILES = ('config/reference_cell.yaml', *SCRIPTS, ORDER, ABLE_CELL, RECIPE, OVERRIDES)

LINE_END = re.compile('\r\n|[\n\r\x85\u2028\u2029]')

TYPES = FakeActionTypes()


@cache
def reference() -> tuple[Cell, Script]:
    """Return the reference cell and its script."""
    cell = read_cell(REFERENCE_CELL, TYPES)
    return cell, read_script(ROOT / SCRIPTS[0], cell, TYPES)


@cache
def able() -> tuple[Cell, Recipe]:
    """Return the cell with capabilities and its recipe."""
    cell = read_cell(ROOT / ABLE_CELL, TYPES)
    return cell, read_recipe(ROOT / RECIPE, cell, TYPES)


def read(name: str, text: str) -> None:
    """Read a text as the kind of file that its name says."""
    cell, process = reference()
    if name in (ABLE_CELL, 'config/reference_cell.yaml'):
        parse_cell(text, name, TYPES)
    elif name == RECIPE:
        parse_recipe(text, name, able()[0], TYPES)
    elif name == OVERRIDES:
        parse_overrides(text, name, able()[1], able()[0])
    elif 'orders' in name:
        order = parse_order(text, name)
        bind_order(order.order, process, 'J1', order.places)
    else:
        parse_script(text, name, cell, TYPES)


def refusal(name: str, text: str) -> Refused | None:
    """Read a text; every finding of a refusal has a place in it, a hint, and fits one line."""
    try:
        read(name, text)
    except Refused as refused:
        _check(refused, text)
        return refused
    return None


def _check(refused: Refused, text: str) -> None:
    assert refused.findings
    last = len(LINE_END.split(text)) + 1
    for finding in refused.findings:
        assert 1 <= finding.line <= last, text
        assert finding.column >= 1, text
        assert finding.what, text
        assert finding.hint, text
        str(finding).encode()
        assert '\n' not in str(finding), text
