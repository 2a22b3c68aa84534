"""Subscriptions and clients as rclpy has them inside, and a waitable that names its parts.

Only this, `lean_executor` and `wait_list` know rclpy's inside.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable, Sequence, Sized
from typing import Any, Protocol

from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.impl.rcutils_logger import RcutilsLogger
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.type_support import check_for_type_support
from rclpy.waitable import NumberOfEntities, Waitable

from bt_orchestrator.ros.qos import SERVICES


class Logger(Protocol):
    """The part of a ROS 2 logger that is needed here."""

    def error(self, message: str) -> object:
        """Report an error."""


def guarded(callback: Callable[[], object], logger: Logger) -> Callable[[], None]:
    """Return a callback that reports what it raises; rclpy would end the executor's loop."""

    def call() -> None:
        try:
            callback()
        except Exception:  # noqa: BLE001 - whatever it is, the others go on
            report(logger)

    return call


def report(logger: Logger) -> None:
    """Report the exception that is being handled."""
    text = f'error in a callback, ignored:\n{traceback.format_exc()}'
    logger.error(text)


def subscription(node: Node, message_class: Any, topic: str, qos: QoSProfile) -> Any:
    """Return a subscription's handle: used within `with`, and destroyed when not in use."""
    check_for_type_support(message_class)
    profile: Any = qos.get_c_qos_profile()
    with node.handle:
        return _rclpy.Subscription(node.handle, message_class, topic, profile)


def count_services(node: Node, full_name: str) -> int:
    """Count the servers of a service in the ROS graph.

    rclpy's own method works the name out and proves it each time, which takes longer.
    """
    with node.handle:
        counted: Any = node.handle
        return int(counted.get_count_services(full_name))


def publisher_ids(node: Node, full_name: str) -> Sequence[str]:
    """Return an id of each publisher of a topic in the ROS graph; no other endpoint has it.

    rclpy's own method makes objects of all that is known of each, which takes far longer.
    """
    with node.handle:
        known: Any = _rclpy.rclpy_get_publishers_info_by_topic(node.handle, full_name, False)
    return [id_of(one['endpoint_gid']) for one in known]


def id_of(gid: Sequence[int]) -> str:
    """Return the id of an endpoint as text."""
    return bytes(gid).hex()


def service_client(node: Node, service_class: Any, name: str) -> Any:
    """Return a service client's handle: used within `with`, and destroyed when not in use."""
    check_for_type_support(service_class)
    profile: Any = SERVICES.get_c_qos_profile()
    with node.handle:
        return _rclpy.Client(node.handle, service_class, name, profile)


# A waitable that names its parts: an executor need not ask it after each wait.

Call = tuple[Callable[[Any], None], Any]
"""A callback, and what it is called with."""


class Part(Protocol):
    """A service client."""

    @property
    def handle(self) -> Any:
        """The return value of `handles`."""

    @property
    def awaited(self) -> Sized:
        """Return what holds the questions that are open: always the same. Empty: none are."""

    def take(self) -> Sequence[Call]:
        """Take all that came, each with what is to be called."""


class PartedWaitable(Waitable):  # type: ignore[type-arg] # no Generic in Jazzy's rclpy
    """Several service clients that run together, in plain calls.

    `LeanExecutor` waits for the parts and calls `note_ready` and `run`; rclpy's executors get the
    same through the interface of its waitables. What a callback raises is reported.

    :ivar parts: do not change
    """

    def __init__(self, node: Node, logger: RcutilsLogger, parts: Sequence[Part]) -> None:
        super().__init__(node.default_callback_group)
        self.parts = tuple(parts)
        self._logger = logger
        self._places: Sequence[tuple[Part, int]] = ()
        self._ready: Sequence[Part] = ()
        node.add_waitable(self)

    def note_ready(self, parts: Sequence[Part]) -> None:
        """Learn for which parts something came."""
        self._ready = parts

    def run(self) -> None:
        """Take what came, and call back."""
        self._call(self.take_data())

    # --- the interface of rclpy's waitables -----------------------------------------------------

    def __enter__(self) -> None:
        for part in self.parts:
            part.handle.__enter__()

    def __exit__(self, *error: Any) -> None:
        for part in self.parts:
            part.handle.__exit__(*error)

    def get_num_entities(self) -> NumberOfEntities:
        """Return how much room it needs in a wait set."""
        return NumberOfEntities(num_clients=len(self.parts))

    def add_to_wait_set(self, wait_set: Any) -> None:
        """Add the parts."""
        self._places = [(part, wait_set.add_client(part.handle)) for part in self.parts]

    def is_ready(self, wait_set: Any) -> bool:
        """Tell whether something came."""
        self.note_ready(
            [part for part, place in self._places if wait_set.is_ready('client', place)]
        )
        return bool(self._ready)

    def take_data(self) -> Sequence[Call]:
        """Take all that came."""
        return [call for part in self._ready for call in part.take()]

    async def execute(self, taken_data: Any) -> None:
        """Call back."""
        self._call(taken_data)

    def _call(self, calls: Sequence[Call]) -> None:
        for call, message in calls:
            try:
                call(message)
            except Exception:  # noqa: BLE001 - whatever it is, the others go on
                report(self._logger)
