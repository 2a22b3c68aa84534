"""References such as ${results.inspect.measurement} in arguments and conditions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal

from bt_orchestrator.errors import MissingResult

Source = Literal['params', 'order', 'item', 'results']


@dataclass(frozen=True)
class Reference:
    """A name for a value that is known when the task starts."""

    source: Source
    name: str
    """Parameter name, `id`, `quantity`, `number`, or the id of the task that gave the result."""
    fields: tuple[str, ...] = ()
    """Field path inside a result."""

    def __str__(self) -> str:
        return '.'.join((self.source, self.name, *self.fields))


@dataclass(frozen=True)
class Template:
    """A string with references in it.

    A string that is exactly one reference keeps the referenced type; otherwise the values are
    formatted into the text (formats: script).
    """

    parts: tuple[str | Reference, ...]

    def __str__(self) -> str:
        return ''.join(p if isinstance(p, str) else f'${{{p}}}' for p in self.parts)


@dataclass(frozen=True)
class Scope:
    """The values that references can name, for one task of one item."""

    params: Mapping[str, Any]
    order: Mapping[str, Any]
    """`id`, `quantity`."""
    item: Mapping[str, Any]
    """`id`, `number`; empty for initialization tasks."""
    results: Mapping[str, Mapping[str, Any]]
    """Results of this item's tasks, by task id."""


def references(value: object) -> Iterator[Reference]:
    """Yield every reference in an argument value, in the order written."""
    if isinstance(value, Template):
        yield from (part for part in value.parts if isinstance(part, Reference))
    elif isinstance(value, Mapping):
        for member in value.values():
            yield from references(member)
    elif isinstance(value, (list, tuple)):
        for member in value:
            yield from references(member)


def resolve(value: Any, scope: Scope) -> Any:
    """Replace every reference in an argument value by what it names.

    :raises MissingResult: the result does not exist for this item (semantics 6.3)
    """
    if isinstance(value, Template):
        if len(value.parts) == 1 and isinstance(value.parts[0], Reference):
            return look_up(value.parts[0], scope)
        return ''.join(
            part if isinstance(part, str) else as_text(look_up(part, scope))
            for part in value.parts
        )
    if isinstance(value, Mapping):
        return {key: resolve(member, scope) for key, member in value.items()}
    if isinstance(value, (list, tuple)):
        return [resolve(member, scope) for member in value]
    return value


def look_up(reference: Reference, scope: Scope) -> Any:
    """Return what a reference names.

    :raises MissingResult: the result does not exist for this item (semantics 6.3)
    """
    value: Any = getattr(scope, reference.source)
    for key in (reference.name, *reference.fields):
        if not isinstance(value, Mapping) or key not in value:
            raise MissingResult(str(reference))
        value = value[key]
    return value


def as_text(value: object) -> str:
    """Write a value as YAML would: true, not Python's True."""
    return str(value).lower() if isinstance(value, bool) else str(value)
