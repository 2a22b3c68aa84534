from __future__ import annotations

from pathlib import Path

import pytest
from fakes.action_types import FakeActionTypes
from fakes.drawn.lines import lines
from fakes.drawn.plan import Plan
from fakes.plan_runs import product_cell, product_scripts
from fakes.profiles import examples
from fakes.script_texts import cell, line
from fakes.shipped import REFERENCE_CELL, TREES
from hypothesis import given

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.script import Script
from bt_orchestrator.script.cell_file import read_cell
from bt_orchestrator.script.script_file import parse_script
from bt_orchestrator.script.writing.script_text import Comments, write_script

TYPES = FakeActionTypes()
SHIPPED = sorted(TREES.glob('*.yaml'))
OWN_WORDS = {
    'reference_process': [
        '  label: {type: str, default: none}',
        '    - {task: TASK_A, action: /component_2a/task, on_failure: continue}',
    ],
    'inspect_by_weight': [
        (
            '      when: {all: ["${results.weigh.item_present}", '
            '{value: "${results.weigh.measurement}", at_least: 5.2}]}'
        ),
    ],
}
"""Lines that a person wrote otherwise."""


def comments_for(script: Script) -> Comments:
    """Say something at every place."""
    return Comments(
        head=['Written by a test, # with a mark.', 'two\nlines ' + 'long ' * 40],
        sections=dict.fromkeys(script.sections, 'of a section'),
        tasks={name: f'of {name}: {{a: "b"}}' for name in script.tasks},
        flags={entry.flag: '- a flag' for entry in script.dependencies},
        zones={entry.name: 'a zone\x07' for entry in script.zones},
    )


def again(text: str, where: Cell) -> Script:
    return parse_script(text, 'written.yaml', where, TYPES)


def assert_same(script: Script, where: Cell) -> None:
    plain, explained = (
        write_script(script, where),
        write_script(script, where, comments_for(script)),
    )
    assert again(plain, where) == script
    assert again(explained, where) == script
    kept = [row for row in explained.splitlines() if not row.lstrip().startswith('#')]
    assert kept == plain.splitlines()
    assert write_script(again(plain, where), where) == plain


@examples(30, 1000)
@given(lines())
def test_drawn_script_reads_back_unchanged(plan: Plan) -> None:
    where = product_cell(plan)
    for script in product_scripts(plan, where).values():
        assert_same(script, where)


@pytest.mark.parametrize('path', SHIPPED, ids=lambda path: path.stem)
def test_shipped_script_is_written_like_its_file(path: Path) -> None:
    where = read_cell(REFERENCE_CELL, TYPES)
    text = path.read_text()
    script = again(text, where)
    assert_same(script, where)
    own = [row for row in text.splitlines() if not row.lstrip().startswith('#')]
    written = write_script(script, where).splitlines()
    assert [row for row in written if row not in own] == OWN_WORDS.get(script.name, [])


EVERYTHING = """\
script: test
made_from: {recipe: WM-100, version: 2, recipe_digest: "1234e5678901", generator: "0.9"}
quantity: 7
params:
  lot: {type: str, default: "7"}
  small: {type: float, default: 1.0e-05}
  needed: {type: bool}
initialization:
  - {task: HOME, action: /belt/index, on_failure: continue, repeatable: true, once: true}
  - {id: ready, task: PREPARE, action: /press/task}
initialization_dependencies:
  - {upstream: init.1, downstream: ready}
sections:
  1:
    - {id: place, task: PLACE_AT_CONVEYOR, action: /loader/task, qty_change: 1}
  2:
    release_conveyor: after_last_conveyor_task
    tasks:
      - parallel:
        - - {task: TASK_A, action: /table/task}
          - {id: "4.10", task: TASK_B, action: /table/task, retry_delay: 0.5, timeout: none}
        - {id: wait, task: DriveTo, action: /cart/drive, requires_conveyor: false}
      - repeat:
        - {id: glue, task: TASK_A, action: /table/task}
        - {id: see, task: TASK_B, action: /table/task, fails_unless: "${results.see.item_present}"}
        times: 2
  3:
    - id: press
      task: TASK_C
      action: /press/task
      args:
        special_argument_1: "Lot ${params.lot} of the order ${order.id}, item ${item.number}"
        special_argument_2: "${results.4.10.measurement}"
      on_failure: reject
      unless: {value: "${results.4.10.item_present}", equals: false}
    - {task: TASK_A, action: /press/task, when: {value: "${item.number}", one_of: [1, 2]}}
  4:
    - {id: pack, task: PICK_AND_PACK, action: /packer/task, qty_change: -1, runs_for: all}
lateral_dependencies:
  - {flag: room, upstream: "2.1", downstream: press, capacity: 3, initial: 1}
zones:
  table: ["4.10", press]
"""


def test_everything_that_a_script_can_say() -> None:
    script = again(EVERYTHING, cell())
    assert_same(script, cell())
    assert write_script(script, cell()) == EVERYTHING


def test_timeout_equal_to_component_default_is_omitted() -> None:
    script = line('  3: [{id: press, task: TASK_A, action: /press/task, timeout: 300}]\n')
    assert '- {id: press, task: TASK_A, action: /press/task}' in write_script(script, cell())
