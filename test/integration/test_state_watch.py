"""Hearing state topics, whatever profile their publishers chose (semantics 2.5)."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any

import pytest
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from ros_bench import RosBench
from std_msgs.msg import Bool, Header, String

from bt_orchestrator.model.cell import Component, StateTopic
from bt_orchestrator.model.goal import StateReading
from bt_orchestrator.ros.actions.state_watch import HEARS_ALL, best_profile

RELIABLE, BEST_EFFORT = ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT
LATCHED, VOLATILE = DurabilityPolicy.TRANSIENT_LOCAL, DurabilityPolicy.VOLATILE

TEXT = StateTopic('/arm/state', 'std_msgs/msg/String', 'data', ('READY',))
NESTED = StateTopic('/arm/state', 'std_msgs/msg/Header', 'stamp.sec', (1,))
SWITCH = StateTopic('/arm/state', 'std_msgs/msg/Bool', 'data', (True,))


def profile(reliability: Any, durability: Any) -> QoSProfile:
    return QoSProfile(depth=1, reliability=reliability, durability=durability)


class World:
    """A bench that listens to one topic, and the readings that came."""

    def __init__(self, state: StateTopic) -> None:
        arm = Component('arm', (1,), '/arm/task', 'test_msgs/action/Fibonacci', state)
        self.bench = RosBench([arm], serve=False)
        self.values: list[Any] = []

    def publisher(self, kind: Any, offered: QoSProfile) -> Any:
        return self.bench.node.create_publisher(kind, '/arm/state', offered)

    def hears(self, *values: Any, saying: Any = None, publisher: Any = None) -> None:
        """Wait until exactly these values have come, while something is said again and again."""

        def heard() -> bool:
            if publisher is not None:
                publisher.publish(saying)
            self.update()
            return len(self.values) >= len(values)

        self.bench.run_until(heard, f'{values}, have {self.values}')
        assert self.values == list(values)

    def hears_no_more(self, *values: Any) -> None:
        self.bench.run_for(1.5)
        self.update()
        assert self.values == list(values)

    @property
    def last(self) -> Any:
        """The value that came last."""
        self.update()
        return self.values[-1]

    def update(self) -> None:
        for entry in self.bench.gateway.drain():
            assert isinstance(entry, StateReading)
            self.values.append(entry.value)


@pytest.fixture
def world(request: pytest.FixtureRequest) -> Iterator[World]:
    world = World(getattr(request, 'param', TEXT))
    yield world
    world.bench.close()


@pytest.mark.parametrize('reliability', [RELIABLE, BEST_EFFORT])
@pytest.mark.parametrize('durability', [LATCHED, VOLATILE])
def test_hears_every_publisher(world: World, reliability: Any, durability: Any) -> None:
    publisher = world.publisher(String, profile(reliability, durability))
    world.hears('READY', saying=String(data='READY'), publisher=publisher)
    world.hears('READY', 'BUSY', saying=String(data='BUSY'), publisher=publisher)


def test_receives_latched_value_published_earlier(world: World) -> None:
    world.bench.gateway.close()
    world.publisher(String, profile(RELIABLE, LATCHED)).publish(String(data='READY'))
    world.bench.run_for(0.2)
    world.bench.gateway = world.bench.make_gateway()
    world.hears('READY')


def test_tells_changes_only(world: World) -> None:
    publisher = world.publisher(String, profile(RELIABLE, LATCHED))
    publisher.publish(String(data='READY'))
    world.hears('READY')
    publisher.publish(String(data='READY'))
    world.hears_no_more('READY')


def test_tells_none_when_the_last_publisher_is_gone(world: World) -> None:
    first, second = (world.publisher(String, profile(RELIABLE, LATCHED)) for _ in range(2))
    first.publish(String(data='READY'))
    world.hears('READY')
    world.bench.node.destroy_publisher(first)
    world.hears_no_more('READY')
    world.bench.node.destroy_publisher(second)
    world.hears('READY', None)
    world.hears_no_more('READY', None)


def test_follows_publisher_returning_with_another_profile(world: World) -> None:
    latched = world.publisher(String, profile(RELIABLE, LATCHED))
    latched.publish(String(data='READY'))
    world.hears('READY')
    world.bench.node.destroy_publisher(latched)
    plain = world.publisher(String, profile(BEST_EFFORT, VOLATILE))
    world.hears('READY', 'BUSY', saying=String(data='BUSY'), publisher=plain)


@pytest.mark.parametrize('world', [NESTED], indirect=True)
def test_field_inside_of_a_message(world: World) -> None:
    message = Header()
    message.stamp.sec = 5
    world.publisher(Header, profile(RELIABLE, LATCHED)).publish(message)
    world.hears(5)


@pytest.mark.parametrize('world', [SWITCH], indirect=True)
def test_false_is_a_value(world: World) -> None:
    world.publisher(Bool, profile(RELIABLE, LATCHED)).publish(Bool(data=False))
    world.hears(False)


@pytest.mark.parametrize(
    ('offers', 'best'),
    [
        ([(RELIABLE, LATCHED)], profile(RELIABLE, LATCHED)),
        ([(RELIABLE, VOLATILE)], profile(RELIABLE, VOLATILE)),
        ([(RELIABLE, LATCHED), (RELIABLE, VOLATILE)], profile(RELIABLE, VOLATILE)),
        ([(RELIABLE, LATCHED), (BEST_EFFORT, LATCHED)], HEARS_ALL),
        ([(BEST_EFFORT, LATCHED)], HEARS_ALL),
    ],
)
def test_best_profile_matches_all_offers(offers: Any, best: QoSProfile) -> None:
    assert best_profile([profile(*offer) for offer in offers]) == best


def test_endlessly_changing_topic_is_reported_at_limited_rate(world: World) -> None:
    publisher = world.publisher(String, profile(RELIABLE, LATCHED))
    numbers = itertools.count()

    def flooded() -> bool:
        publisher.publish(String(data=f'{next(numbers)} {"x" * 60_000}'))
        world.update()
        return next(numbers) > 2_000

    world.bench.run_until(flooded, 'the end of the flood')
    assert sum(map(len, world.values)) < 200_000
    publisher.publish(String(data='READY'))
    world.bench.run_until(lambda: world.last == 'READY', 'the newest value')
