"""The files around the texts in the tables of mistakes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from textwrap import indent
from typing import NamedTuple

from fakes.recipe_texts import RECIPE
from fakes.script_texts import LINE

CELL_FILE, SCRIPT_FILE, ORDER_FILE = (
    f'{kind}.schema.json' for kind in ('cell', 'script', 'work_order')
)
RECIPE_FILE, OVERRIDES_FILE = 'recipe.schema.json', 'overrides.schema.json'

COMPONENT = """\
cell: c
conveyor: {{sections: 3, action: /belt/index, type: plain_interfaces/action/Index}}
components:
  arm: {{{}}}
"""
NAMED = 'action: /arm/task, type: test_interfaces/action/Rich,\n    '
BELT = """\
cell: c
conveyor: {{action: /belt/index, {}}}
components: {{a: {{action: /arm/task, type: test_interfaces/action/Rich, section: 3}}}}
"""

TASK = '  2: [{{task: RUN, action: /camera/task{}}}]\n'
INITIALIZATION = 'initialization: [{{task: RUN, action: /lamp/task, {}}}]\n'
ARGUMENTS = '  2: [{{task: RUN, action: /camera/task, args: {{{}}}}}]\n'
REFERENCE = """\
  2: [{{id: look, task: RUN, action: /camera/task}}]
  3: [{{id: use, task: TASK_A, action: /press/task, args: {{{}}}}}]
params: {{lot: {{type: str}}, n: {{type: int}}, x: {{type: float}}, b: {{type: bool}}}}
"""
CONDITION = """\
  2: [{{id: look, task: RUN, action: /camera/task}}, {{task: RUN, action: /camera/task,
    {}}}]
params: {{b: {{type: bool}}, n: {{type: int}}, s: {{type: str}}, x: {{type: float}}}}
"""
VERDICT = """\
  2: [{{id: look, task: RUN, action: /camera/task}}, {{id: judged, task: RUN, action: /camera/task,
    {}}}]
params: {{x: {{type: float}}}}
"""
LOTS = """\
initialization: [{{id: set, task: RUN, action: /lamp/task}}]
params: {{lot: {{type: str}}, n: {{type: int}}, x: {{type: float}}, b: {{type: bool}}}}
lots: {}
"""
RELATED = """\
  2: [{id: look, task: RUN, action: /camera/task}]
  3: [{id: press, task: TASK_A, action: /press/task}]
initialization: [{id: home, task: HOME, action: /belt/index}, \
{id: ready, task: PREPARE, action: /loader/task}, {id: set, task: RUN, action: /lamp/task}]
"""


class Around(NamedTuple):
    """What a table is about, and how one of its texts becomes a whole file."""

    file: str
    """Name of the schema."""
    whole: Callable[[str], str]


def _in_line(text: str) -> str:
    return LINE + text


AROUND: Mapping[str, Around] = {
    'arguments': Around(SCRIPT_FILE, lambda text: LINE + ARGUMENTS.format(text)),
    'balance': Around(SCRIPT_FILE, str),
    'bindings': Around(ORDER_FILE, lambda text: f'script: test\n{text}'),
    'capabilities': Around(CELL_FILE, lambda text: COMPONENT.format(NAMED + text)),
    'cells': Around(CELL_FILE, str),
    'component_names': Around(CELL_FILE, COMPONENT.format),
    'component_options': Around(CELL_FILE, lambda text: COMPONENT.format(NAMED + text)),
    'conditions': Around(SCRIPT_FILE, lambda text: LINE + CONDITION.format(text)),
    'conveyor': Around(CELL_FILE, BELT.format),
    'dependencies': Around(SCRIPT_FILE, lambda text: LINE + RELATED + text),
    'groups': Around(SCRIPT_FILE, _in_line),
    'ids': Around(SCRIPT_FILE, _in_line),
    'initialization_options': Around(SCRIPT_FILE, lambda text: LINE + INITIALIZATION.format(text)),
    'operations': Around(RECIPE_FILE, lambda text: RECIPE.format(indent(text, '  '))),
    'likely': Around(SCRIPT_FILE, lambda text: LINE + CONDITION.format(text)),
    'lots': Around(SCRIPT_FILE, lambda text: LINE + LOTS.format(text)),
    'orders': Around(ORDER_FILE, str),
    'overrides': Around(OVERRIDES_FILE, str),
    'parameters': Around(SCRIPT_FILE, _in_line),
    'recipes': Around(RECIPE_FILE, str),
    'reference_order': Around(SCRIPT_FILE, _in_line),
    'references': Around(SCRIPT_FILE, lambda text: LINE + REFERENCE.format(text)),
    'scripts': Around(SCRIPT_FILE, str),
    'repeats': Around(SCRIPT_FILE, _in_line),
    'section_rules': Around(SCRIPT_FILE, _in_line),
    'sections': Around(SCRIPT_FILE, _in_line),
    'setups': Around(CELL_FILE, lambda text: COMPONENT.format(NAMED + text)),
    'verdicts': Around(SCRIPT_FILE, lambda text: LINE + VERDICT.format(text)),
    'task_names': Around(SCRIPT_FILE, _in_line),
    'task_options': Around(SCRIPT_FILE, lambda text: LINE + TASK.format(text)),
}
"""By the name of the table; `yaml` is about YAML itself."""
