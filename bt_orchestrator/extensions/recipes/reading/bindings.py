"""Whether a component can do an operation that is bound to it."""

from __future__ import annotations

from typing import NamedTuple

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.recipe import Recipe
from bt_orchestrator.script.report import did_you_mean, listing
from bt_orchestrator.script.yaml_nodes import quoted


class Unbound(NamedTuple):
    """Why a binding does not hold."""

    what: str
    hint: str


def unknown_operation(name: str, recipe: Recipe, what: str) -> Unbound | None:
    """Say that a recipe has no such operation; None: it has.

    :param what: what names it: override for
    """
    if name in recipe.by_id:
        return None
    version = f'version {recipe.version} of {recipe.name}'
    hint = did_you_mean(name, recipe.by_id, 'remove it')
    return Unbound(f'{what} {quoted(name)}: no such operation in {version}', hint)


def misfit(operation_id: str, component: str, recipe: Recipe, cell: Cell) -> Unbound | None:
    """Say why a component cannot do an operation; None: it can."""
    operation = recipe.by_id[operation_id]
    able = [
        one.name
        for one in cell.components.values()
        if not one.capabilities.keys().isdisjoint(operation.do)
    ]
    if component in able:
        return None
    what = f'bind {operation.id}: there is no component {quoted(component)}'
    if component in cell.components:
        does = ' or '.join(f'`{one}`' for one in operation.do)
        what = f'bind {operation.id}: `{component}` does not have {does}'
    return Unbound(what, did_you_mean(component, able, f'only {listing(able)} can do it'))
