"""A second participant in the same ROS graph, used when the first one does not hear a server."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterator

import rclpy
from rclpy.context import Context
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from unique_identifier_msgs.msg import UUID

from bt_orchestrator.model.goal import SILENCE_S
from bt_orchestrator.ros.actions.goal_client import GoalClient

KEPT_FRESH_S = 60.0
"""Seconds for which a participant counts as fresh; the shortest time between two of them."""


class FreshParticipant:
    """A node in a context of its own, and so with another DDS participant and other ports.

    The middleware may discover a server only in part, and for good: then no client of the old
    participant is answered, while one of a fresh participant is. Callbacks run in the executor
    of the node beside it. Takes some 20 ms to make.
    """

    def __init__(self, beside: Node, name: str) -> None:
        """Join the domain and the namespace of a node.

        :param name: of the new node; tools do not list one that begins with `_`
        """
        executor = beside.executor
        assert executor is not None, 'somebody has to run the callbacks'
        self._executor = executor
        self._context = Context()
        rclpy.init(
            args=[],
            context=self._context,
            domain_id=beside.context.get_domain_id(),
            signal_handler_options=SignalHandlerOptions.NO,
        )
        self.node = Node(
            name,
            context=self._context,
            namespace=beside.get_namespace(),
            use_global_arguments=False,
            enable_rosout=False,
            start_parameter_services=False,
        )
        self.made_s = time.monotonic()
        executor.add_node(self.node)

    def close(self) -> None:
        """Leave the graph; what is on its node must have been destroyed."""
        self._executor.remove_node(self.node)
        self.node.destroy_node()
        self._context.try_shutdown()


class FreshParticipants:
    """The participants of a gateway; clients that need one at the same time share it."""

    def __init__(self, beside: Node) -> None:
        self._beside = beside
        self._made = 0
        self._kept: list[FreshParticipant] = []

    def node(self, kept_s: float = KEPT_FRESH_S) -> Node:
        """Return a node whose participant is fresh.

        :param kept_s: how many seconds old it may be
        """
        if not self._kept or time.monotonic() - self._kept[-1].made_s > kept_s:
            self._made += 1
            name = f'_{self._beside.get_name()}_{self._made}'
            self._kept.append(FreshParticipant(self._beside, name))
        return self._kept[-1].node

    def keep(self, used: Collection[Node]) -> None:
        """Close all but the freshest and those whose nodes are used."""
        old = [each for each in self._kept[:-1] if each.node not in used]
        for each in old:
            self._kept.remove(each)
            each.close()

    def close(self) -> None:
        """Close all of them."""
        for each in self._kept:
            each.close()
        self._kept.clear()


# The client of one action, which can be replaced by one on a fresh participant.


class RenewableClient:
    """States: as it was made, renewed (any number of times), destroyed.

    :ivar current: the client to speak with

    The one before the current one is kept: a late answer to one of its requests is of interest.
    """

    def __init__(
        self, node: Node, make: Callable[[Node], GoalClient], fresh_node: Callable[[], Node]
    ) -> None:
        """Make the first client.

        :param make: makes a client of the action on a node
        :param fresh_node: returns a node with a fresh participant
        """
        self._make = make
        self._fresh_node = fresh_node
        self._former: GoalClient | None = None
        self._renewed_s: float | None = None
        self.current = make(node)

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
        self.current = self._make(node or self._fresh_node())
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
