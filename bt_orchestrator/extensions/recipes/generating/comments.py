"""Remarks of a generated script about its lines: facts that stay, no figures."""

from __future__ import annotations

from collections.abc import Collection

from bt_orchestrator.extensions.recipes.generating.inputs import Inputs
from bt_orchestrator.extensions.recipes.planning.outcome import Generated, Made, Why
from bt_orchestrator.script.writing.script_text import Comments


def comments_of(found: Generated, inputs: Inputs, without: Collection[str]) -> Comments:
    """Return the comments of a generated script."""
    recipe = inputs.recipe
    origin_of_all = (
        f'Generated from version {recipe.version} of the recipe {recipe.name} for the cell '
        f'{inputs.cell.name}. Do not edit it: change the recipe, the cell or the overrides, '
        'and generate it again.'
    )
    lacking = f'Without {", ".join(sorted(without))}.'
    head = [origin_of_all, lacking] if without else [origin_of_all]
    return Comments(head, tasks={task: origin(made) for task, made in found.made.items()})


def origin(made: Made) -> str:
    """Say where a task came from, and why this component does it."""
    if not made.capability:
        return f'prepares {made.component}'
    what = made.operation
    if made.capability != made.operation:
        what += f' ({made.capability})'
    return f'{what} by {made.component}: {reason(made)}'


def reason(made: Made) -> str:
    """Say why a component does an operation."""
    others = [one for one in made.alternatives if one != made.component]
    if made.why is Why.ONLY or not others:
        return made.why.value
    return f'{made.why.value}; {", ".join(others)} could too'
