"""Listening to one component's state topic (semantics 2.5)."""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from typing import Any

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from bt_orchestrator.model.cell import Component, StateTopic
from bt_orchestrator.model.goal import StateReading
from bt_orchestrator.ports.news import News
from bt_orchestrator.ports.spare_log import SpareLog
from bt_orchestrator.ros.actions.state_flow import StateFlow
from bt_orchestrator.ros.executor.callbacks import guarded, report
from bt_orchestrator.ros.executor.timers import steady_timer
from bt_orchestrator.ros.types.interface_classes import message_class
from bt_orchestrator.ros.types.messages import field_value

_WAITING_S = 0.1
"""Between two looks for a value that had to wait."""

HEARS_ALL = QoSProfile(
    depth=1,
    reliability=ReliabilityPolicy.BEST_EFFORT,
    durability=DurabilityPolicy.VOLATILE,
)
"""Matches every publisher, and misses messages that were published before."""


class StateWatch:
    """Reports the value of the field when it has changed; None when no publisher is left.

    Of a topic that changes without end the newest value is reported, when it may be.

    No one profile both hears every publisher and gets the latched value of those that keep one.
    So it begins with the one that hears all, looks at the publishers once a second, and subscribes
    anew with the best profile that all of them offer.
    """

    def __init__(self, node: Node, component: Component, state: StateTopic, news: News) -> None:
        """Subscribe.

        :raises UnknownActionType: the message type is not installed
        """
        self._node = node
        self._component = component.name
        self._topic = state.topic
        self._path = state.field.split('.')
        self._class = message_class(state.type)
        self._news = news
        self._flow = StateFlow(state.ready)
        self._logger = SpareLog(node.get_logger().get_child(component.name))
        self._timer = steady_timer(node, _WAITING_S, guarded(self._tell_newest, self._logger))
        self._timer.cancel()
        self._subscribe(HEARS_ALL)

    def look(self) -> None:
        """Look at the publishers; called once a second."""
        publishers = self._node.get_publishers_info_by_topic(self._topic)
        if not publishers:
            self._hear(None)
            return
        wanted = best_profile([publisher.qos_profile for publisher in publishers])
        if wanted != self._profile:
            self._node.destroy_subscription(self._subscription)
            self._subscribe(wanted)

    def close(self) -> None:
        """Stop listening."""
        self._node.destroy_timer(self._timer)
        self._node.destroy_subscription(self._subscription)

    def _subscribe(self, profile: QoSProfile) -> None:
        self._profile = profile
        self._subscription = self._node.create_subscription(
            self._class,
            self._topic,
            self._on_message,
            profile,
            # A publisher of another kind is no mistake here: the next look adapts to it.
            event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=False),
        )

    def _on_message(self, message: Any) -> None:
        try:
            self._hear(field_value(message, self._path))
        except Exception:  # noqa: BLE001 - one bad message, the cell goes on
            report(self._logger)

    def _hear(self, value: Any) -> None:
        self._tell(self._flow.hear(value, time.monotonic()))
        if self._flow.is_waiting and self._timer.is_canceled():
            self._timer.reset()

    def _tell_newest(self) -> None:
        self._tell(self._flow.look(time.monotonic()))
        if not self._flow.is_waiting:
            self._timer.cancel()

    def _tell(self, values: Iterable[Any]) -> None:
        for value in values:
            self._news.add(StateReading(self._component, value))


def best_profile(offers: Sequence[QoSProfile]) -> QoSProfile:
    """Return the best profile that matches all publishers.

    Latched values are asked for only where delivery is reliable, as they are not sent otherwise.
    """
    if any(offer.reliability is not ReliabilityPolicy.RELIABLE for offer in offers):
        return HEARS_ALL
    latched = all(offer.durability is DurabilityPolicy.TRANSIENT_LOCAL for offer in offers)
    return QoSProfile(
        depth=1,
        reliability=ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )
