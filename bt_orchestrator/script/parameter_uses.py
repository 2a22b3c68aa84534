"""Values of an order against the goal fields that they go into."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from bt_orchestrator.model.action_type import ActionType, FieldType
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.reference import Reference, Template
from bt_orchestrator.model.script import Script
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.script.checks.arguments import member_type
from bt_orchestrator.script.field_types import misfit
from bt_orchestrator.script.references import is_single
from bt_orchestrator.script.yaml_nodes import found_value


class Misuse(NamedTuple):
    """A value that does not fit a field."""

    path: tuple[str, ...]
    """Of the order's key."""
    what: str
    hint: str


def action_types(cell: Cell, types: ActionTypes) -> dict[str, ActionType]:
    """Return the action type of every component of a cell, by the component's name.

    :raises UnknownActionType: one is not installed
    """
    return {name: types.action(one.type) for name, one in cell.components.items()}


def misfitting_uses(
    script: Script,
    order_id: str,
    quantity: int,
    params: Mapping[str, Any],
    types: Mapping[str, ActionType],
) -> Iterator[Misuse]:
    """Yield the order's values that some task's goal cannot hold, each use once."""
    known: dict[tuple[str, str], Any] = {('params', name): params[name] for name in params}
    known |= {('order', 'id'): order_id, ('order', 'quantity'): quantity}
    for task in script.tasks.values():
        goal = types[task.component].goal
        for name, value in task.args.items():
            for reference, field, type_ in _whole_references(value, goal.fields[name], name):
                given = known.get((reference.source, reference.name))
                problem = misfit(given, type_) if given is not None else None
                if problem is not None:
                    where = f'`{field}` of the task `{task.id}`'
                    what = f'`{reference}` must be {problem.needed} for {where}'
                    yield Misuse(
                        _path(reference), f'{what}, not {found_value(given)}', problem.hint
                    )


def _path(reference: Reference) -> tuple[str, ...]:
    if reference.source == 'params':
        return ('params', reference.name)
    return ('order',) if reference.name == 'id' else (reference.name,)


def _whole_references(
    value: Any, type_: FieldType, name: str
) -> Iterator[tuple[Reference, str, FieldType]]:
    """Yield the references that are a field's whole value, with the field's name and type."""
    if isinstance(value, Template):
        part = value.parts[0]
        if is_single(value) and isinstance(part, Reference):
            yield part, name, type_
    elif isinstance(value, Mapping) and type_.message is not None:
        for key, member in value.items():
            yield from _whole_references(member, type_.message.fields[key], f'{name}.{key}')
    elif isinstance(value, list):
        for number, member in enumerate(value):
            yield from _whole_references(member, member_type(type_), f'{name}[{number}]')
