"""Texts read as one of the three kinds of files, and what a refusal has to say."""

from __future__ import annotations

import re
from functools import cache

from fakes.action_types import FakeActionTypes
from fakes.shipped import REFERENCE_CELL, ROOT

from bt_orchestrator.errors import Refused
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.script import Script
from bt_orchestrator.script.cell_file import parse_cell, read_cell
from bt_orchestrator.script.orders.order_file import bind_order, parse_order
from bt_orchestrator.script.script_file import parse_script, read_script

SCRIPTS = (
    'trees/reference_process.yaml',
    'trees/inspect_and_assemble.yaml',
    'test/data/stuck.yaml',
)
FILES = ('config/reference_cell.yaml', *SCRIPTS, 'config/orders/wo_1001.yaml')
KINDS = (FILES[0], FILES[1], FILES[-1])
"""One file of each kind."""

LINE_END = re.compile('\r\n|[\n\r\x85\u2028\u2029]')

TYPES = FakeActionTypes()


@cache
def reference() -> tuple[Cell, Script]:
    """Return the reference cell and its script."""
    cell = read_cell(REFERENCE_CELL, TYPES)
    return cell, read_script(ROOT / SCRIPTS[0], cell, TYPES)


def read(name: str, text: str) -> None:
    """Read a text as the kind of file that its name says."""
    cell, process = reference()
    if name.endswith('cell.yaml'):
        parse_cell(text, name, TYPES)
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
