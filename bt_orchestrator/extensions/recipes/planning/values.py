"""The values of a task: what a recipe names, in the names of the component that was chosen."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from bt_orchestrator.extensions.recipes.planning.candidates import Candidate
from bt_orchestrator.model.condition import Condition
from bt_orchestrator.model.recipe import Operation
from bt_orchestrator.model.reference import Reference, Template


class Values:
    """The values of the tasks of one plan."""

    def __init__(self, chosen: Mapping[str, Candidate]) -> None:
        """Take the candidate of each operation."""
        self._chosen = chosen

    def args(self, candidate: Candidate) -> dict[str, Any]:
        """Return the goal fields of a task."""
        capability, operation = candidate.capability, candidate.operation
        found = _copy(capability.args)
        for name, value in operation.parameters.items():
            if name in capability.parameters:  # or it is one of the alternative in `do`
                _put(found, capability.parameters[name], self.renamed(value))
        for name, field in capability.needs.items():
            given = self._given(operation, name)
            if given is not None and field:
                _put(found, field, Template((given,)))
        return found

    def options(self, candidate: Candidate) -> dict[str, Any]:
        """Return the other fields of a task."""
        options = {name: self.renamed(value) for name, value in candidate.options.items()}
        given = candidate.operation.options.get('identifies')  # of a capability: a result field
        if given is not None:
            own = Reference('results', candidate.operation.id, given)
            options['identifies'] = self._in_result(own).fields
        return options

    def _given(self, operation: Operation, name: str) -> Reference | None:
        """Return what an earlier operation gives; None: the device keeps it."""
        giver = operation.needs[name]
        if name not in self._chosen[giver].capability.gives:
            return None
        return self._in_result(Reference('results', giver, (name,)))

    def renamed(self, value: Any) -> Any:
        """Return a value in which references name fields of results."""
        match value:
            case Template(parts):
                return Template(
                    tuple(one if isinstance(one, str) else self._in_result(one) for one in parts)
                )
            case Condition():
                return replace(
                    value,
                    value=self.renamed(value.value),
                    at_least=self.renamed(value.at_least),
                    at_most=self.renamed(value.at_most),
                    all=tuple(self.renamed(one) for one in value.all),
                    any=tuple(self.renamed(one) for one in value.any),
                )
            case Mapping():
                return {key: self.renamed(member) for key, member in value.items()}
            case list():
                return [self.renamed(member) for member in value]
        return value

    def _in_result(self, reference: Reference) -> Reference:
        if reference.source != 'results' or not reference.fields:
            return reference
        name, *path = reference.fields
        field = self._chosen[reference.name].capability.gives.get(name, name)
        return replace(reference, fields=(*field.split('.'), *path))


def _copy(args: Mapping[str, Any]) -> dict[str, Any]:
    return {
        key: _copy(value) if isinstance(value, Mapping) else value for key, value in args.items()
    }


def _put(args: dict[str, Any], field: str, value: Any) -> None:
    """Set a goal field; dots lead into nested messages."""
    *path, last = field.split('.')
    for name in path:
        args = args.setdefault(name, {})
    args[last] = value
