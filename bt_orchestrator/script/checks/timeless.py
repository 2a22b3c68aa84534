"""Tasks without a nominal time: who predicts with them, or chooses by them, is misled."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from itertools import chain
from pathlib import Path

from bt_orchestrator.base.errors import Finding
from bt_orchestrator.model.cell import CONVEYOR, Cell
from bt_orchestrator.model.recipe import Recipe
from bt_orchestrator.model.script import Script
from bt_orchestrator.script.composing import compose
from bt_orchestrator.script.report import Report, did_you_mean
from bt_orchestrator.script.source_text import read_text
from bt_orchestrator.script.yaml_nodes import place_of_key

Kind = tuple[str, str]
"""A component and one of its task constants, or labels."""


def timeless_words(kind: Kind, cell: Cell) -> tuple[str, str] | None:
    """Say that the cell file has no nominal time for a task, and what to do; None: it has one.

    A cell file without any nominal times is not meant for predictions. The conveyor has one time
    for all its tasks.
    """
    name, task = kind
    component = cell.components[name]
    is_for_prediction = any(one.durations_s for one in cell.components.values())
    if name == CONVEYOR or not is_for_prediction or task in component.durations_s:
        return None
    default = component.default_duration_s
    what = f'`{task}` of `{name}` has no nominal time: predictions take {default:g} s'
    hint = f'add `{task}: SECONDS` to the `durations` of `{name}`'
    near = did_you_mean(task, component.durations_s, '')
    return what, f'{hint}; {near}' if near else hint


def of_scripts(scripts: Iterable[Script]) -> Iterator[Kind]:
    """Yield what scripts do."""
    for script in scripts:
        listed = (tasks.tasks for tasks in script.sections.values())
        for task in chain(script.initialization, *listed):
            yield task.component, task.name


def of_recipe(recipe: Recipe, cell: Cell) -> Iterator[Kind]:
    """Yield all that could do an operation of a recipe: `generate` chooses by these times."""
    wanted = {name for operation in recipe.operations for name in operation.do}
    for component in cell.components.values():
        for name, capability in component.capabilities.items():
            if name in wanted:
                yield component.name, capability.task


def timeless(cell_file: Path, cell: Cell, kinds: Iterable[Kind]) -> tuple[Finding, ...]:
    """Return a warning for each task without a nominal time, at its component in the cell file."""
    found = Report(str(cell_file))
    root = None
    for kind in dict.fromkeys(kinds):
        words = timeless_words(kind, cell)
        if words is not None:
            root = root or compose(read_text(cell_file), Report(''))
            found.add(place_of_key(root, 'components', kind[0], 'durations'), *words)
    return found.findings
