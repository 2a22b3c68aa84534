"""Listening to one component's state topic (semantics 2.5)."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from typing import Any

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from bt_orchestrator.model.cell import Component, SafetyInput, StateTopic
from bt_orchestrator.model.codec import json_of
from bt_orchestrator.model.goal import NOT_HEARD, SafetyReading, SetupReading, StateReading
from bt_orchestrator.model.limits import (
    STATE_VALUE_BYTES,
    STATE_VALUE_SHORT,
    STATES_OF_ONE,
    Allowance,
    cut,
    shortened,
)
from bt_orchestrator.model.words import sentence
from bt_orchestrator.ports.news import News
from bt_orchestrator.ports.spare_log import SpareLog, guarded, report
from bt_orchestrator.ros.actions.goal_client import own_endpoint
from bt_orchestrator.ros.actions.rivals import placed
from bt_orchestrator.ros.executor.alarms import steady_timer
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
        self._setups = {name: setup for name, setup in component.setups.items() if setup.reads}
        self._setup_flows = {name: SetupFlow(setup.values) for name, setup in self._setups.items()}
        self._logger = SpareLog(node.get_logger().get_child(component.name))
        self._timer = steady_timer(node, _WAITING_S, guarded(self._tell_newest, self._logger))
        self._timer.cancel()
        self._subscribe(HEARS_ALL)

    def tell_again(self) -> None:
        """Report the last value once more, if there is one."""
        if self._flow.told is not None:
            self._tell([self._flow.told])

    def look(self) -> None:
        """Look at the publishers; called once a second."""
        publishers = self._node.get_publishers_info_by_topic(self._topic)
        if not publishers:
            self._hear(None, dict.fromkeys(self._setups))
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
            setups = {
                name: setup.told(field_value(message, setup.reads.split('.')))
                for name, setup in self._setups.items()
            }
            self._hear(field_value(message, self._path), setups)
        except Exception:  # noqa: BLE001 - one bad message, the cell goes on
            report(self._logger)

    def _hear(self, value: Any, setups: Mapping[str, str | None]) -> None:
        """Tell setups first: no goal is sent to a component that is ready, but not known."""
        now = time.monotonic()
        for name, flow in self._setup_flows.items():
            self._tell_setup(name, flow.hear(setups[name], now))
        self._tell(self._flow.hear(value, now))
        if self._is_waiting and self._timer.is_canceled():
            self._timer.reset()

    def _tell_newest(self) -> None:
        now = time.monotonic()
        for name, flow in self._setup_flows.items():
            self._tell_setup(name, flow.look(now))
        self._tell(self._flow.look(now))
        if not self._is_waiting:
            self._timer.cancel()

    @property
    def _is_waiting(self) -> bool:
        return any(flow.is_waiting for flow in (self._flow, *self._setup_flows.values()))

    def _tell(self, values: Iterable[Any]) -> None:
        for value in values:
            self._news.add(StateReading(self._component, value))

    def _tell_setup(self, setup: str, values: Iterable[Any]) -> None:
        for value in values:
            self._news.add(SetupReading(self._component, setup, value))


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


# The safety input: a topic that has to be heard again and again (semantics 7.9).

HEARD_AFTER_S = 3.0
"""How long a publisher may need to be found when the node starts."""

LATE_S = 0.02
"""How long a message that is late may wait in this process: one more turn of the executor."""


class SafetyWatch:
    """Knows at every moment why the safety input is not ready, and tells each change.

    Ready means: one publisher, which keeps no messages for others, and a message within the time
    that has a good value. Every time is of the steady clock.
    """

    def __init__(
        self, node: Node, wanted: SafetyInput, news: News, say: Callable[[str], object]
    ) -> None:
        """Subscribe.

        :param say: is called with why the input is not ready at this moment; empty: it is
        :raises UnknownActionType: the message type is not installed
        """
        self._node = node
        self._wanted = wanted
        self._path = wanted.field.split('.')
        self._news = news
        self._say = say
        self._period_s = min(wanted.within_s / 4, _WAITING_S)
        self._began: float | None = None
        """When this thread began to serve the node; None: it has not."""
        self._looked = self._before = time.monotonic()
        self._is_contested = False
        """There are several publishers."""
        self._heard: float | None = None
        """When the last message came; None: none has."""
        self._value = ''
        """The fault of its value; empty: it is good."""
        self._publishers = NOT_HEARD
        """The fault of the publishers; empty: there is one, as it has to be."""
        self._told: str | None = None
        self._is_late = False
        self._logger = SpareLog(node.get_logger().get_child('safety'))
        self._subscription = node.create_subscription(
            message_class(wanted.type),
            wanted.topic,
            self._on_message,
            HEARS_ALL,
            event_callbacks=SubscriptionEventCallbacks(use_default_callbacks=False),
        )
        look = guarded(self._look, self._logger)
        self._timer = steady_timer(node, self._period_s, look)
        self._again = steady_timer(node, LATE_S, guarded(self._look_again, self._logger))
        self._again.cancel()

    def close(self) -> None:
        """Stop listening."""
        self._node.destroy_timer(self._timer)
        self._node.destroy_timer(self._again)
        self._node.destroy_subscription(self._subscription)

    def _on_message(self, message: Any) -> None:
        now = time.monotonic()
        # If this thread was busy for long, the message may have come as soon as it was.
        is_fresh = now - self._before <= 3 * self._period_s
        self._heard = now if is_fresh else self._before
        self._is_late = False
        try:
            value = field_value(message, self._path)
        except Exception as error:  # noqa: BLE001 - whatever it is, the value cannot be read
            self._value = sentence('unsafe_unreadable', words=f'{error!r:.200}')
        else:
            is_good = any(_same(value, good) for good in self._wanted.ready)
            self._value = '' if is_good else sentence('unsafe_value', value=shown(value))
        self._look_at_publishers()
        self._tell()

    def _look(self) -> None:
        self._before, self._looked = self._looked, time.monotonic()
        self._began = self._began or self._looked
        self._look_at_publishers()
        if self._age_s() > self._wanted.within_s and not self._is_late and self._told == '':
            self._is_late = True  # a message may wait behind this timer
            self._again.reset()
        elif not self._is_late:
            self._tell()

    def _look_again(self) -> None:
        self._again.cancel()
        self._is_late = False
        self._tell()

    def _look_at_publishers(self) -> None:
        endpoints = self._node.get_publishers_info_by_topic(self._subscription.topic_name)
        self._is_contested = len(endpoints) > 1
        if self._is_contested:
            topic = self._subscription.topic_name
            where = ', '.join(placed(endpoints, own_endpoint(self._node, topic)))
            self._publishers = sentence(
                'unsafe_publishers', count=len(endpoints), publishers=where
            )
        elif not endpoints:
            self._publishers = sentence('unsafe_unpublished')
        elif endpoints[0].qos_profile.durability is DurabilityPolicy.TRANSIENT_LOCAL:
            self._publishers = sentence('unsafe_latched')
        else:
            self._publishers = ''

    def _age_s(self) -> float:
        return float('inf') if self._heard is None else time.monotonic() - self._heard

    def _why(self) -> str:
        """Return why the input is not ready now; empty: it is."""
        if self._age_s() <= self._wanted.within_s:
            return self._publishers or self._value
        is_early = self._began is None or time.monotonic() - self._began < HEARD_AFTER_S
        if self._told is None and is_early and not self._is_contested:
            return NOT_HEARD  # until now this thread has started the node
        silent = sentence('unsafe_silent', seconds=f'{self._wanted.within_s:g}')
        return self._publishers or silent

    def _tell(self) -> None:
        why = self._why()
        self._say(why)
        is_change = self._told is None or bool(why) is not bool(self._told)
        if is_change and why != NOT_HEARD:
            self._told = why
            self._news.add(SafetyReading(why))


def shown(value: Any) -> str:
    """Return a value of a field for people, not too long."""
    return cut(str(value), 100)


# Limits the values of one state topic: it cannot flood the journal (2.5).

_RECORD_BYTES = 200
"""Bytes of a record without the value."""

UNCLEAR = ''
"""Told of a setup whose value has ended, while the next one has to wait."""


class StateFlow:
    """Tells every change while there are not too many, else the newest value when it may.

    That a component is not ready any more is told at once, whatever came before. Every time is one
    of a steady clock.
    """

    def __init__(self, ready: Collection[Any]) -> None:
        """Begin.

        :param ready: the values that mean ready
        """
        self._ready = ready
        self._allowance = Allowance(STATES_OF_ONE)
        self._newest: Any = None
        self.told: Any = None
        """The value that was reported last."""

    @property
    def is_waiting(self) -> bool:
        """Tell whether the newest value was not told yet."""
        return not _same(self._newest, self.told)

    def hear(self, value: Any, now: float) -> Iterator[Any]:
        """Take the newest value; yield the values that are due now."""
        self._newest = value
        yield from self.look(now)

    def look(self, now: float) -> Iterator[Any]:
        """Yield the newest value if it waits and is due."""
        if not self.is_waiting:
            return
        left = self._allowance.left(now)
        for kept in self.forms():
            least = len(kept) if isinstance(kept, str) else 0  # of its JSON, which takes long
            must = self._must_be_told(kept)
            if _RECORD_BYTES + least > left and not must:
                continue
            size = _RECORD_BYTES + len(json_of(kept))
            if size <= left or must:
                self._allowance.use(size, now)
                self.told = kept if kept == UNCLEAR else self._newest
                yield kept
                return

    def forms(self) -> Iterator[Any]:
        """Yield the value as it may be kept, and shorter."""
        if self._newest in self._ready:
            yield self._newest
            return
        whole = shortened(self._newest, STATE_VALUE_BYTES)
        yield whole
        yield shortened(whole, STATE_VALUE_SHORT)

    def _must_be_told(self, kept: Any) -> bool:
        ends = self.told in self._ready and kept not in self._ready
        return ends and len(json_of(kept)) <= 8 * STATE_VALUE_SHORT


class SetupFlow(StateFlow):
    """The same for a setup: it tells at once that a value has ended.

    Where the next value has to wait, the setup is unclear until then.
    """

    def forms(self) -> Iterator[Any]:
        """Yield also that it is unclear, once a value has ended."""
        yield from super().forms()
        if self.told in self._ready:
            yield UNCLEAR


def _same(value: Any, other: Any) -> bool:
    """Tell whether two values are equal and of one type: 1 and True are equal in Python."""
    return type(value) is type(other) and bool(value == other)
