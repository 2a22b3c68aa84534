"""References such as ${results.inspect.measurement} in arguments and conditions."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal

from bt_orchestrator.base.errors import MissingResult
from bt_orchestrator.model.frozen import made_at_once

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


@made_at_once
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

    :raises MissingResult: see `look_up`
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

    :raises MissingResult: the result does not exist for this item, or is or contains a number that
        is not finite (semantics 6.3)
    """
    value: Any = getattr(scope, reference.source)
    for key in (reference.name, *reference.fields):
        if not isinstance(value, Mapping) or key not in value:
            raise MissingResult(str(reference))
        value = value[key]
    bad = _not_finite(value)
    if bad is not None:
        place, number = bad
        what = f'has {number} at {place.removeprefix(".")}' if place else f'is {number}'
        raise MissingResult(str(reference), f'{what}, which is no finite number')
    return value


def _not_finite(value: object) -> tuple[str, float] | None:
    """Return the place in a value, and the number, of its first NaN or infinity."""
    if isinstance(value, float):
        return None if math.isfinite(value) else ('', value)
    if isinstance(value, Mapping):
        return _first_not_finite(value.items(), '.{}')
    return (
        _first_not_finite(enumerate(value), '[{}]') if isinstance(value, (list, tuple)) else None
    )


def _first_not_finite(
    members: Iterable[tuple[object, object]], step: str
) -> tuple[str, float] | None:
    for key, member in members:
        bad = _not_finite(member)
        if bad is not None:
            return step.format(key) + bad[0], bad[1]
    return None


def as_text(value: object) -> str:
    """Write a value as YAML would: true, not Python's True."""
    return str(value).lower() if isinstance(value, bool) else str(value)
