"""Small cells and recipes in YAML, and the script that comes of them."""

from __future__ import annotations

from collections.abc import Mapping
from textwrap import dedent, indent
from typing import Any

from fakes.action_types import FakeActionTypes

from bt_orchestrator.extensions.recipes.planning.generate import generate
from bt_orchestrator.extensions.recipes.planning.outcome import LIMITS, Generated, Judge, Limits
from bt_orchestrator.extensions.recipes.reading.overrides_file import parse_overrides
from bt_orchestrator.extensions.recipes.reading.recipe_file import parse_recipe
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.recipe import Overrides, Recipe
from bt_orchestrator.model.script import Script
from bt_orchestrator.script.cell_file import parse_cell
from bt_orchestrator.sim.pace_judge import PaceJudge
from bt_orchestrator.store.memory import MemoryStore

TYPES = FakeActionTypes()

ENDS = {
    'feeder': 'section: 1, capabilities: {put: {task: TASK_A, qty_change: 1}}',
    'packer': 'section: 4, capabilities: {pack: {task: TASK_A, qty_change: -1}}',
}
"""Components of the ends of a belt of four sections."""


def cell_of(components: Mapping[str, str], sections: int = 4) -> Cell:
    """Return a cell; its belt moves in 1 s.

    :param components: keys of each, in YAML; each task takes 1 s unless they say otherwise
    """
    belt = 'action: /belt, type: bt_orchestrator_interfaces/action/Conveyor, task: MOVE_ONE_INDEX'
    home = 'prepare: {id: home, task: HOME, once: true}'
    lines = [
        'cell: small',
        f'conveyor: {{sections: {sections}, {belt}, duration: 1.0, {home}}}',
        'components:',
    ]
    type_ = 'type: bt_orchestrator_interfaces/action/Component'
    for name, keys in components.items():
        of_type = '' if 'type: ' in keys else f'{type_}, '
        lines.append(f'  {name}: {{action: /{name}/do, {of_type}{keys}}}')
    return parse_cell('\n'.join(lines), 'cell.yaml', TYPES)


def recipe_of(cell: Cell, operations: str, head: str = '') -> Recipe:
    """Read a recipe: its operations in YAML, a line each, and further lines of its head."""
    text = f'recipe: R\nversion: 1\nscript: made\n{head}operations:\n'
    return parse_recipe(text + indent(dedent(operations).strip('\n'), '  '), 'r.yaml', cell, TYPES)


def made_of(
    components: Mapping[str, str],
    operations: str,
    *,
    overrides: str = '',
    without: str = '',
    keep: Script | None = None,
    judge: Judge | None = None,
    sections: int = 4,
    limits: Limits = LIMITS,
) -> Generated:
    """Generate a script."""
    cell = cell_of(components, sections)
    recipe = recipe_of(cell, operations)
    parsed = parse_overrides(overrides, 'o.yaml', recipe, cell) if overrides else Overrides()
    return generate(
        cell,
        recipe,
        parsed,
        without=frozenset(without.split()),
        keep=keep,
        judge=judge or PaceJudge(cell, TYPES, MemoryStore),
        limits=limits,
    )


def lists(script: Script) -> dict[int, list[Any]]:
    """Return the ids in each list; those of a parallel group in a list of their own."""
    return {
        number: [
            [[task.id for task in track] for track in step.tracks]
            if step.is_group
            else step.tracks[0][0].id
            for step in section.steps
        ]
        for number, section in script.sections.items()
    }
