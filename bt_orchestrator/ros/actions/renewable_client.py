"""The client of one action, which can be replaced by one on a fresh participant."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import Any

from rclpy.node import Node
from unique_identifier_msgs.msg import UUID

from bt_orchestrator.model.goal import SILENCE_S
from bt_orchestrator.ros.actions.fresh_participant import KEPT_FRESH_S
from bt_orchestrator.ros.actions.goal_client import GoalClient


class RenewableClient:
    """States: as it was made, renewed (any number of times), destroyed.

    :ivar current: the client to speak with

    The one before the current one is kept: a late answer to one of its requests is of interest.
    """

    def __init__(
        self, node: Node, action_class: Any, name: str, fresh_node: Callable[[], Node]
    ) -> None:
        """Make the first client.

        :param fresh_node: returns a node with a fresh participant
        """
        self._class = action_class
        self._name = name
        self._fresh_node = fresh_node
        self._former: GoalClient | None = None
        self._renewed_s: float | None = None
        self.current = GoalClient(node, action_class, name)

    @property
    def may_be_renewed(self) -> bool:
        """Tell whether it has not been renewed for a while."""
        return self._age_s > KEPT_FRESH_S

    @property
    def is_looking(self) -> bool:
        """Tell whether it is so fresh that it may not have found the server yet."""
        return self._age_s < SILENCE_S

    @property
    def nodes(self) -> Iterator[Node]:
        """Nodes that are in use."""
        yield from (client.node for client in self._clients)

    def renew(self, node: Node | None = None) -> None:
        """Speak through a fresh participant from now on.

        :param node: its node, if it was made already
        """
        if self._former is not None:
            self._former.destroy()
        self._former = self.current
        self.current = GoalClient(node or self._fresh_node(), self._class, self._name)
        self._renewed_s = time.monotonic()

    def forget(self, goal_id: UUID) -> None:
        """Free what was kept for a goal."""
        for client in self._clients:
            client.forget(goal_id)

    def destroy(self) -> None:
        """Leave."""
        for client in self._clients:
            client.destroy()

    @property
    def _clients(self) -> Iterator[GoalClient]:
        yield self.current
        if self._former is not None:
            yield self._former

    @property
    def _age_s(self) -> float:
        if self._renewed_s is None:
            return float('inf')
        return time.monotonic() - self._renewed_s
