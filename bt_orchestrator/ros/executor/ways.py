"""How rclpy is used, by the executor and by what action clients are made of: two ways.

The lean one knows rclpy's inside (`lean_parts`, `lean_executor`). The plain one, below, is made of
what rclpy promises to keep; it takes more of the processor.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple, Protocol

from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import QoSProfile

from bt_orchestrator.ports.spare_log import Logger, report
from bt_orchestrator.ros.node_parameters import PLAIN
from bt_orchestrator.ros.qos import create_client, subscribe

Answered = Callable[[Any], None]
"""Gets the response."""


class Question(Protocol):
    """A request that was sent. States: open, then answered or dropped."""

    @property
    def is_open(self) -> bool:
        """Tell whether the answer is still waited for."""

    def drop(self) -> None:
        """Wait for the answer no longer; it may never come."""


class Questions(Protocol):
    """A client of one service."""

    def ask(self, request: Any, answered: Answered) -> Question:
        """Send a request.

        :param answered: called with the response, in the executor's thread
        """

    def tell(self, request: Any) -> None:
        """Send a request whose answer does not matter."""

    def is_served(self) -> bool:
        """Tell whether the service is there; goes through the whole ROS graph."""

    def servers(self) -> int:
        """Count those who serve it; goes through the whole ROS graph."""


class Connections(NamedTuple):
    """Publishers that a subscription has been connected to."""

    ever: int
    """How many in all: it grows with each that comes, also where one leaves at the same moment."""
    now: int


class LastMessage(Protocol):
    """A topic. Its last message is kept."""

    @property
    def publishers(self) -> int:
        """How many are connected; costs next to nothing."""

    @property
    def connections(self) -> Connections | None:
        """How many are and were connected; costs next to nothing. None: rclpy does not tell."""

    def read(self) -> Any:
        """Return the last message, the same one again until another came; None: none came."""

    def destroy(self) -> None:
        """End the subscription."""


def _every(_: Any) -> bool:
    return True


class Service(NamedTuple):
    """A service that an action client asks."""

    kind: Any
    name: str
    is_last: Callable[[Any], bool] = _every
    """Whether a response ends a question: of several servers with one name each gives its own.
    In the plain way every response does, as rclpy hands out the first alone."""


class Way(NamedTuple):
    """How rclpy is used."""

    executor: Callable[..., Executor]
    """Makes the executor `single`; takes `context`."""
    clients: Callable[
        [Node, Logger, Sequence[Service]], tuple[Sequence[Questions], Callable[[], None]]
    ]
    """Makes a client for each service, and what ends them; what an answer raises is reported."""
    last_message: Callable[[Node, Any, str, QoSProfile], LastMessage]
    """Subscribes to a topic of depth 1."""


# The plain way.


class PlainLastMessage:
    """A subscription that keeps what comes; each message is a turn of the executor."""

    def __init__(self, node: Node, kind: Any, topic: str, qos: QoSProfile) -> None:
        """Subscribe."""
        self._node = node
        self._last: Any = None
        self._subscription = subscribe(node, kind, topic, self._take, qos)

    @property
    def publishers(self) -> int:
        """How many are connected."""
        return int(self._subscription.get_publisher_count())

    @property
    def connections(self) -> None:
        """Return None: rclpy tells it in turns of the executor, too late to prove anything."""

    def read(self) -> Any:
        """Return the last message that had its turn; None: none had."""
        return self._last

    def destroy(self) -> None:
        """End the subscription."""
        self._node.destroy_subscription(self._subscription)

    def _take(self, message: Any) -> None:
        self._last = message


class PlainQuestion:
    """A request that was sent. States: open, then answered or dropped."""

    def __init__(self, future: Any) -> None:
        self._future = future

    @property
    def is_open(self) -> bool:
        """Tell whether the answer is still waited for."""
        return not (self._future.done() or self._future.cancelled())

    def drop(self) -> None:
        """Wait for the answer no longer; the client forgets it."""
        self._future.cancel()


class PlainQuestions:
    """One service; each answer is called back in a turn of its own, the first one alone."""

    def __init__(self, node: Node, logger: Logger, service: Service) -> None:
        """Make the client."""
        self._logger = logger
        self._client = create_client(node, service.kind, service.name)
        self.servers = partial(node.count_services, node.resolve_service_name(service.name))
        self.destroy = partial(node.destroy_client, self._client)

    def ask(self, request: Any, answered: Answered) -> PlainQuestion:
        """Send a request.

        :param answered: called with the first response
        """
        future = self._client.call_async(request)
        future.add_done_callback(partial(self._hear, answered))
        return PlainQuestion(future)

    def tell(self, request: Any) -> None:
        """Send a request whose answer does not matter."""
        self._client.call_async(request).cancel()

    def is_served(self) -> bool:
        """Tell whether the service is there."""
        return bool(self._client.service_is_ready())

    def _hear(self, answered: Answered, future: Any) -> None:
        if future.cancelled():
            return
        try:
            answered(future.result())
        except Exception:  # noqa: BLE001 - whatever it is, the others go on
            report(self._logger)


def plain_clients(
    node: Node, logger: Logger, services: Sequence[Service]
) -> tuple[Sequence[PlainQuestions], Callable[[], None]]:
    """Return a client for each service, and what ends them."""
    clients = [PlainQuestions(node, logger, service) for service in services]
    return clients, partial(_end, clients)


def _end(clients: Sequence[PlainQuestions]) -> None:
    for client in clients:
        client.destroy()


# Which way it is.


def plain_way() -> Way:
    """Return the way that rclpy promises to keep."""
    return Way(SingleThreadedExecutor, plain_clients, PlainLastMessage)


def lean_way(node: Node) -> Way:
    """Return the way that knows rclpy's inside.

    :raises StrangeInside: it is another one; says where
    """
    try:
        # By their names: a strange rclpy may have none of what they import.
        parts = importlib.import_module('bt_orchestrator.ros.executor.lean_parts')
        lean = importlib.import_module('bt_orchestrator.ros.executor.lean_executor')
        strange = parts.strange(node)
    except Exception as error:
        raise StrangeInside(f'{type(error).__name__}: {error}') from error
    if strange:
        raise StrangeInside(strange)
    return Way(lean.LeanExecutor, parts.lean_clients, parts.LeanLastMessage)


class StrangeInside(Exception):
    """The inside of rclpy is not the one that is known."""


def choose_way(client: str, node: Node) -> Way:
    """Return the way that a parameter `client` asks for; warn if the lean one cannot be had."""
    if client == PLAIN:
        return plain_way()
    try:
        return lean_way(node)
    except StrangeInside as error:
        node.get_logger().warning(
            f'the rclpy installed here has another inside than the one that is known ({error}); '
            'the node uses what rclpy promises to keep, which takes more of the processor'
        )
        return plain_way()
