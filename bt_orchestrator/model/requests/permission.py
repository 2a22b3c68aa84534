"""Permissions of requests, and which need a reason (semantics 7.1)."""

from __future__ import annotations

from collections.abc import Collection

from bt_orchestrator.model.by import By, Known
from bt_orchestrator.model.requests.request import Request, Why
from bt_orchestrator.model.roles import Role


def refusal(request: Request, by: By, given: Collection[str] = ()) -> str | None:
    """Say why a sender may not make a request, or not without a reason; None: allowed.

    :param given: the parameters that it comes with
    """
    restricted = [one for one in request.parameters if one.roles is not None and one.name in given]
    for name, roles in (
        (request.name, request.roles),
        *((f'{request.name} with {one.name}', one.roles or request.roles) for one in restricted),
    ):
        if by.role not in roles:
            return _not_allowed(name, roles, by)
    if request.why is Why.FIRST and not by.reason.strip():
        return f'{request.name} needs a reason, for the record; nothing was done'
    return None


def _not_allowed(name: str, roles: Collection[Role], by: By) -> str:
    may = ' or '.join(role.value for role in Role if role in roles)
    said = (
        f'{name} is for the role {may}, and {by.named} has the role {by.role.value} '
        f'({by.known.value}); nothing was done'
    )
    if by.claims:
        said += f'; the role {by.claims} does not count, since the node does not trust that door'
    if by.known is Known.ROS:
        said += (
            '; the parameter unauthenticated_role of the node is the role of everybody in the '
            'ROS domain'
        )
    return said
