"""A line on which serials are read."""

from __future__ import annotations

from fakes.action_types import FakeActionTypes
from fakes.line import expanded
from fakes.virtual_run import VirtualRun

from bt_orchestrator.model.script import Script
from bt_orchestrator.script.cell_file import parse_cell
from bt_orchestrator.script.script_file import parse_script

TYPES = FakeActionTypes()
CELL = """
cell: reading
conveyor: {sections: 3, action: /belt/do, duration: 2.0, task: MOVE_ONE_INDEX,
  type: bt_orchestrator_interfaces/action/Conveyor}
components:
  a1: {section: 1, action: /a1/do, type: bt_orchestrator_interfaces/action/Component}
  a2: {section: 2, action: /a2/do, type: test_interfaces/action/Rich, durations: {RUN: 1.0},
    results: {RUN: {code: "SERIAL", count: COUNT}}, faults: [FAULTS]}
  a3: {section: 3, action: /a3/do, type: bt_orchestrator_interfaces/action/Component}
"""
READ = """
script: test
sections:
  1: [{id: place, @a1, qty_change: 1}]
  2: [{id: read, @a2.RUN, identifies: FIELD OPTIONS}]
  3: [{id: pack, @a3, qty_change: -1, runs_for: all}]
"""


class Reading:
    """The section in the middle reads them."""

    def __init__(self, serial: str = 'S-{n}', faults: str = '', count: int = 0) -> None:
        text = CELL.replace('SERIAL', serial).replace('FAULTS', faults)
        self.cell = parse_cell(text.replace('COUNT', str(count)), 'cell.yaml', TYPES)
        self.run = VirtualRun(self.cell, TYPES)

    def script(self, options: str = '', field: str = 'code') -> Script:
        text = expanded(READ.replace('OPTIONS', options).replace('FIELD', field))
        return parse_script(text, 'test.yaml', self.cell, TYPES)

    def go(self, quantity: int = 1, options: str = '', field: str = 'code') -> VirtualRun:
        self.run.submit('J', self.script(options, field), quantity)
        return self.run.go()
