"""A request with its arguments, checked against the table; who may make it."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from bt_orchestrator.model.by import By, Known, Role
from bt_orchestrator.model.limits import cut
from bt_orchestrator.model.requests.request import About, Kind, Parameter, Request, Why
from bt_orchestrator.model.requests.table import REQUESTS, TABLE, of_name
from bt_orchestrator.model.words import joined, sentence


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
        wrong = repr(cut(name, 60))
        raise BadArguments(sentence('no_request', found=wrong, requests=', '.join(near)))
    known = {parameter.name: parameter for parameter in request.parameters}
    given = {key: value for key, value in arguments.items() if value is not None}
    for key in given:
        if key not in known:
            expected = ', '.join(known) or 'nothing'
            raise BadArguments(sentence('takes', request=name, parameters=expected, found=key))
    for parameter in request.parameters:
        if parameter.name in given:
            _check(name, parameter, given[parameter.name])
        elif parameter.is_required:
            raise BadArguments(sentence('lacks', request=name, **_named(parameter)))
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
    least, most = parameter.span
    if not _is_of(parameter.kind, value):
        expected: dict[str, object] = {'kind': parameter.kind.value}
        kind = 'not_of_kind'
    elif isinstance(value, int) and not least <= value <= most:
        kind, expected = 'not_in_span', {'low': least, 'high': most}
    elif parameter.choices and value not in parameter.choices:
        kind, expected = 'not_chosen', {'choices': ', '.join(parameter.choices)}
    else:
        return
    about = {'request': name, **_named(parameter), 'found': repr(value)}
    raise BadArguments(sentence(kind, **about, **expected))


def _named(parameter: Parameter) -> dict[str, str]:
    return {'parameter': parameter.name, 'meaning': parameter.meaning}


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
    restricted = {
        parameter.name: parameter.roles
        for parameter in request.parameters
        if parameter.roles is not None and parameter.name in given
    }
    for name, roles in {'': request.roles, **restricted}.items():
        if by.role not in roles:
            return joined(*_not_allowed(request, name, roles, by))
    if request.why is Why.FIRST and not by.reason.strip():
        return sentence('needs_reason', request=request.name)
    return None


def _not_allowed(
    request: Request, parameter: str, roles: Collection[Role], by: By
) -> Iterator[str]:
    """Say that a role is another one.

    :param parameter: that alone asks for another role; empty: the request does
    """
    yield sentence(
        'not_for_role_with' if parameter else 'not_for_role',
        request=request.name,
        parameter=parameter,
        roles=' or '.join(role.value for role in Role if role in roles),
        who=by.named,
        role=by.role.value,
        known=by.known.value,
    )
    if by.claims:
        yield sentence('role_not_trusted', claims=by.claims)
    if by.known is Known.ROS:
        yield sentence('role_of_ros')
