"""Sender and role of a request over ROS; ROS does not authenticate senders (docs/security.md)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from bt_orchestrator.base.diagnosis.domain import is_local
from bt_orchestrator.model.by import By, Known
from bt_orchestrator.model.limits import NAME, cut
from bt_orchestrator.model.roles import Role
from bt_orchestrator.model.texts import readable
from bt_orchestrator.ros.node_parameters import AUTO, NodeParameters

_ROLES = {role.value: role for role in Role}
_DOORS = {known.value: known for known in Known if known.is_door}


class Senders:
    """Determines the role of each sender."""

    def __init__(
        self, parameters: NodeParameters, environment: Mapping[str, str], middleware: str
    ) -> None:
        """Set which roles are trusted, for as long as the node runs.

        :param environment: variables that say how far ROS reaches
        :param middleware: name of the RMW implementation
        """
        self.is_local = is_local(environment, middleware)
        self.unauthenticated = _unauthenticated(parameters, is_local=self.is_local)
        self.trusts_doors = parameters.trust_local_doors and self.is_local

    def by(self, request: Any, otherwise: str = 'service') -> By:
        """Return the sender, the origin, the reason and the role.

        :param otherwise: where from, if the request does not say it
        """
        origin = request.origin or otherwise
        said = (request.who, origin, request.reason)
        door = _DOORS.get(request.known)
        if self.trusts_doors and door is not None:
            # A role that this node does not know may do nothing.
            return By(*said, _ROLES.get(request.role, Role.VIEW), door)
        return By(*said, self.unauthenticated, Known.ROS, _claims(request))

    def of_cancel(self, goal_by: By) -> By:
        """Return the sender of a cancel request, which may be any client."""
        who, origin = goal_by.who, goal_by.origin
        return By(who, origin, 'the goal was cancelled', self.unauthenticated, Known.ROS)


def _unauthenticated(parameters: NodeParameters, *, is_local: bool) -> Role:
    if parameters.unauthenticated_role == AUTO:
        return Role.ENGINEER if is_local else Role.VIEW
    return Role(parameters.unauthenticated_role)


def _claims(request: Any) -> str:
    if not request.role:
        return ''
    how = f' ({request.known})' if request.known else ''
    return cut(readable(f'{request.role}{how}'), NAME)
