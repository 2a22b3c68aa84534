"""The recipe parts of a starter cell: the abilities of each device, and a first recipe for it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping

from bt_orchestrator.model.cell import CONVEYOR
from bt_orchestrator.script.cell_file import CELL_FILE
from bt_orchestrator.script.starter.starter_files import (
    ORDER_FILE,
    RECIPE_FILE,
    SCRIPT,
    SCRIPT_FILE,
    cell_text,
    order_text,
    with_schemas,
)
from bt_orchestrator.script.starter.starter_plan import Device, Plan

_RECIPE = """\
# How one product is made, whatever line makes it. A script for this cell comes of it by:
# bt-orchestrator generate {file} --cell {cell} -o {script_file}
recipe: {script}
version: 1
script: {script}  # name of what is generated
operations:  # each comes after the one above it, unless `after` says otherwise
"""


def starter_recipe_files(name: str, plan: Plan, schemas: Mapping[str, str]) -> dict[str, str]:
    """Return the texts of a starter cell with a recipe, from which the script is generated."""
    texts = {
        CELL_FILE: cell_text(name, plan, _able),
        RECIPE_FILE: _recipe_text(plan),
        ORDER_FILE: order_text(),
    }
    return with_schemas(texts, schemas)


def _recipe_text(plan: Plan) -> str:
    """Return a recipe that uses every device once."""
    head = _RECIPE.format(file=RECIPE_FILE, cell=CELL_FILE, script=SCRIPT, script_file=SCRIPT_FILE)
    names = (name for device in plan.components for name, *_ in _capabilities(device, plan))
    return head + ''.join(f'  - {{id: {name}, do: {name}}}\n' for name in names)


def _able(device: Device, plan: Plan, indent: str) -> Iterator[str]:
    """Yield the lines of the cell file that say what a device can do."""
    preparing = [task for task in device.preparations if task != plan.index_task]
    if preparing:
        once = ', once: true' if device.name == CONVEYOR else ''
        prepare = f'{{id: prepare_{device.name}, task: {preparing[0]}{once}}}'
        yield f'{indent}prepare: {prepare}  # before the first item\n'
    if device.name == CONVEYOR:
        return
    yield f'{indent}capabilities:  # what recipes may ask for: tasks, with the keys of a task\n'
    for name, task, options in _capabilities(device, plan):
        yield f'{indent}  {name}: {{task: {task or name}{options}}}\n'


def _capabilities(device: Device, plan: Plan) -> Iterator[tuple[str, str | None, str]]:
    """Yield name, task and further keys of each."""
    for task, options in _works(device, plan):
        yield _name(device, task, plan), task, options


def _works(device: Device, plan: Plan) -> Iterator[tuple[str | None, str]]:
    if device is plan.source:
        *ahead, placing = plan.placing
        yield from ((task, ', requires_conveyor: false') for task in ahead)
        yield placing, ', qty_change: 1'
    elif device is plan.sink:
        yield plan.taking, ', qty_change: -1, runs_for: all'
    else:
        yield device.works[0], ''


def _name(device: Device, task: str | None, plan: Plan) -> str:
    """Return a name that no other device has."""
    if task is None:
        return device.name
    every = Counter(
        other_task for other in plan.components for other_task, _ in _works(other, plan)
    )
    return task.lower() if every[task] == 1 else f'{device.name}_{task.lower()}'
