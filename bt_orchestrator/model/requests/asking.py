"""A request with its arguments, checked against the table; who may make it."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any

from bt_orchestrator.model.by import By, Known, Role
from bt_orchestrator.model.limits import cut
from bt_orchestrator.model.requests.request import About, Kind, Parameter, Request, Why
from bt_orchestrator.model.requests.table import REQUESTS, TABLE, of_name


class BadArguments(ValueError):
    """Unknown or missing arguments of a request; the message says what was expected."""


@dataclass(frozen=True)
class Asked:
    """A request, its subject, and its sender."""

    request: Request
    by: By | None
    """None: the plan of a virtual run, without a node to ask."""
    arguments: Mapping[str, Any] = field(default_factory=dict)
    """By name; parameters that were not given are left out."""

    def __getitem__(self, name: str) -> Any:
        return self.arguments[name]

    @property
    def sender(self) -> By:
        """The person or program that asks."""
        assert self.by is not None, f'{self.request.name} is of a plan'
        return self.by

    @property
    def about(self) -> Mapping[str, str]:
        """The field of records that names its subject."""
        return about_of(self.request.name, self.arguments)


def about_of(name: str, given: Mapping[str, Any]) -> Mapping[str, str]:
    """Return the field of records that names the subject of a request, be it known or not.

    The subject of a command to the cell is the hold that it names.
    """
    kind, _, _ = name.partition('.')
    kind = About.HOLD.value if kind == About.CELL.value else kind
    subject = given.get(kind)
    field = 'digest' if kind == About.SCRIPT.value else kind
    return {field: subject} if subject and isinstance(subject, str) else {}


def ask(name: str, by: By, /, **arguments: object) -> Asked:
    """Return a request with its arguments; those that are None are left out.

    :param name: for instance hold.retry
    :raises BadArguments: it has other parameters, one is missing, or a value is none of its kind
    """
    request = of_name(name)
    if request is None:
        kind, _, _ = name.partition('.')
        near = [request.name for request in TABLE if request.about.value == kind] or REQUESTS
        raise BadArguments(f'there is no request {cut(name, 60)!r}; one of {", ".join(near)}')
    known = {parameter.name: parameter for parameter in request.parameters}
    given = {key: value for key, value in arguments.items() if value is not None}
    for key in given:
        if key not in known:
            expected = ', '.join(known) or 'nothing'
            raise BadArguments(f'{name} takes {expected}; found {key}')
    for parameter in request.parameters:
        if parameter.name in given:
            _check(name, parameter, given[parameter.name])
        elif parameter.is_required:
            raise BadArguments(f'{name} needs {parameter.name}: {parameter.meaning}')
    return Asked(request, by, given)


_TYPES: Mapping[Kind, tuple[type, ...]] = {
    Kind.TEXT: (str,),
    Kind.WHOLE: (int,),
    Kind.YES_NO: (bool,),
    Kind.TEXTS: (list, tuple),
    Kind.VALUES: (Mapping,),
    Kind.ORDERS: (list, tuple),
}


def _check(name: str, parameter: Parameter, value: object) -> None:
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
        return isinstance(value, (list, tuple)) and all(isinstance(text, str) for text in value)
    return not (kind is Kind.WHOLE and isinstance(value, bool))


# Permissions of requests, and which need a reason (semantics 7.1).


def refusal(request: Request, by: By, given: Collection[str] = ()) -> str | None:
    """Say why a sender may not make a request, or not without a reason; None: allowed.

    :param given: the parameters that it comes with
    """
    restricted = [
        parameter
        for parameter in request.parameters
        if parameter.roles is not None and parameter.name in given
    ]
    for name, roles in (
        (request.name, request.roles),
        *(
            (f'{request.name} with {parameter.name}', parameter.roles or request.roles)
            for parameter in restricted
        ),
    ):
        if by.role not in roles:
            return _not_allowed(name, roles, by)
    if request.why is Why.FIRST and not by.reason.strip():
        return f'{request.name} needs a reason, for the record; nothing was done'
    return None


def _not_allowed(name: str, roles: Collection[Role], by: By) -> str:
    may = ' or '.join(role.value for role in Role if role in roles)
    message = (
        f'{name} is for the role {may}, and {by.named} has the role {by.role.value} '
        f'({by.known.value}); nothing was done'
    )
    if by.claims:
        message += (
            f'; the role {by.claims} does not count, since the node does not trust that door'
        )
    if by.known is Known.ROS:
        message += (
            '; the parameter unauthenticated_role of the node is the role of everybody in the '
            'ROS domain who does not sign, and view where signed_commands is required'
        )
    return message
