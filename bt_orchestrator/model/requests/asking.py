"""A request with its arguments, checked against the table."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from bt_orchestrator.model.by import By
from bt_orchestrator.model.requests.request import Kind, Parameter, Request
from bt_orchestrator.model.requests.table import REQUESTS


class BadArguments(ValueError):
    """Unknown or missing arguments of a request; the message says what was expected."""


@dataclass(frozen=True)
class Asked:
    """A request, its subject, and its sender."""

    request: Request
    by: By
    arguments: Mapping[str, object] = field(default_factory=dict)
    """By name; parameters that were not given are left out."""


def ask(name: str, by: By, /, **arguments: object) -> Asked:
    """Return a request with its arguments; those that are None are left out.

    :param name: in `REQUESTS`, for instance hold.retry
    :raises BadArguments: it has other parameters, one is missing, or a value is none of its kind
    """
    request = REQUESTS.get(name)
    if request is None:
        raise BadArguments(f'there is no request {name!r}; one of {", ".join(REQUESTS)}')
    known = {parameter.name: parameter for parameter in request.parameters}
    given = {key: value for key, value in arguments.items() if value is not None}
    for key in given:
        if key not in known:
            expected = ', '.join(known) or 'nothing'
            raise BadArguments(f'{name} takes {expected}; found {key}')
    for parameter in request.parameters:
        _check(name, parameter, given)
    return Asked(request, by, given)


_TYPES: Mapping[Kind, tuple[type, ...]] = {
    Kind.TEXT: (str,),
    Kind.WHOLE: (int,),
    Kind.YES_NO: (bool,),
    Kind.TEXTS: (list, tuple),
    Kind.VALUES: (Mapping,),
    Kind.ORDERS: (list, tuple),
}


def _check(name: str, parameter: Parameter, given: Mapping[str, object]) -> None:
    if parameter.name not in given:
        if parameter.is_required:
            raise BadArguments(f'{name} needs {parameter.name}: {parameter.meaning}')
        return
    value = given[parameter.name]
    if not _is_of(parameter.kind, value):
        expected = f'{parameter.name} of {name} is {parameter.kind.value}'
        raise BadArguments(f'{expected} ({parameter.meaning}); found {value!r}')
    least, most = parameter.span
    if isinstance(value, int) and not least <= value <= most:
        expected = f'{parameter.name} of {name} is a whole number from {least} to {most}'
        raise BadArguments(f'{expected} ({parameter.meaning}); found {value}')
    if parameter.choices and value not in parameter.choices:
        choices = ', '.join(parameter.choices)
        raise BadArguments(f'{parameter.name} of {name} is one of {choices}; found {value!r}')


def _is_of(kind: Kind, value: object) -> bool:
    if not isinstance(value, _TYPES[kind]):
        return False
    if kind is Kind.TEXTS:
        return isinstance(value, (list, tuple)) and all(isinstance(one, str) for one in value)
    return not (kind is Kind.WHOLE and isinstance(value, bool))
