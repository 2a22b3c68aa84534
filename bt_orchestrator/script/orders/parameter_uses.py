"""Values of an order against the goal fields that they go into, and the conditions they bound."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from bt_orchestrator.model.action_type import ActionType, FieldType
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.condition import Condition
from bt_orchestrator.model.reference import Reference, Template, references
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.words import sentence
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.script.checks.arguments import member_type
from bt_orchestrator.script.conditions.reader import are_crossed
from bt_orchestrator.script.field_types import PARAMETER_TYPES, Misfit, misfit
from bt_orchestrator.script.references import FIXED, is_single
from bt_orchestrator.script.yaml_nodes import found_value


class Misuse(NamedTuple):
    """A value that does not fit a field, or a condition."""

    path: tuple[str, ...]
    """Of the order's key."""
    what: str
    hint: str


def _misuse(
    path: tuple[str, ...], kind: str, problem: Misfit, value: object, **names: object
) -> Misuse:
    what = sentence(kind, needed=problem.needed, given=found_value(value), **names)
    return Misuse(path, what, problem.hint)


def action_types(cell: Cell, types: ActionTypes) -> dict[str, ActionType]:
    """Return the action type of every component of a cell, by the component's name.

    :raises UnknownActionType: one is not installed
    """
    return {name: types.action(component.type) for name, component in cell.components.items()}


def misfitting_uses(
    script: Script,
    order_id: str,
    quantity: int,
    params: Mapping[str, Any],
    types: Mapping[str, ActionType],
) -> Iterator[Misuse]:
    """Yield the order's values that some task's goal or condition cannot take, each use once."""
    known: dict[tuple[str, str], Any] = {('params', name): params[name] for name in params}
    known |= {('order', 'id'): order_id, ('order', 'quantity'): quantity}
    for task in script.tasks.values():
        goal = types[task.component].goal
        for name, value in task.args.items():
            for reference, field, type_ in _whole_references(value, goal.fields[name], name):
                given = known.get((reference.source, reference.name))
                problem = misfit(given, type_) if given is not None else None
                if problem is not None:
                    names = {'name': reference, 'field': field, 'task': task.id}
                    yield _misuse(_path(reference), 'param_in_goal', problem, given, **names)
        for compared in task.comparisons:
            yield from _misfitting_bounds(
                compared, task.id, params, _value_type(compared, script, types)
            )


def _misfitting_bounds(
    compared: Condition, task: str, params: Mapping[str, Any], type_: FieldType | None
) -> Iterator[Misuse]:
    """Yield bounds that cannot be compared, and `between` that no value can meet (6.5)."""
    bounds = (compared.at_least, compared.at_most)
    given = [_bound(bound, params) for bound in bounds]
    named = [
        (reference.name, value)
        for bound, value in zip(bounds, given, strict=True)
        for reference in references(bound)
    ]
    for name, value in named:
        problem = misfit(value, type_) if type_ is not None and value is not None else None
        if problem is not None:
            names = {'name': f'params.{name}', 'task': task}
            yield _misuse(('params', name), 'in_condition', problem, value, **names)
    if named and are_crossed(*given):
        what = sentence('crossed', low=given[0], high=given[1], task=task)
        yield Misuse(('params', named[-1][0]), what, sentence('lower_first'))


def _bound(bound: Any, params: Mapping[str, Any]) -> Any:
    """Return a bound as the order has it; None if there is none."""
    return next((params.get(reference.name) for reference in references(bound)), bound)


def _value_type(
    compared: Condition, script: Script, types: Mapping[str, ActionType]
) -> FieldType | None:
    """Return the type of what a condition compares; None if it is text of several parts."""
    named = compared.value.parts[0]
    if not is_single(compared.value) or not isinstance(named, Reference):
        return None
    if named.source == 'params':
        return PARAMETER_TYPES[script.params[named.name].type]
    if named.source != 'results':
        return FIXED[named.source][named.name]
    fields, type_ = types[script.tasks[named.name].component].result.fields, None
    for name in named.fields:
        type_ = fields[name]
        fields = type_.message.fields if type_.message else {}
    return type_


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
