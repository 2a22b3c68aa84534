"""What is told of the cell while the disk is waited for."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest
from fakes import statuses

from bt_orchestrator.model import events as e
from bt_orchestrator.ros.clock import MachineUptime
from bt_orchestrator.ros.services import outputs
from bt_orchestrator.ros.services.outputs import StatusTopic


class Clock:
    """A node's clock, its publisher and its timer."""

    def __init__(self) -> None:
        self.now_s = 1000
        self.told: list[tuple[int, int, str]] = []
        self.listeners = 0
        self.scheduled = False
        self.timer = SimpleNamespace(
            cancel=lambda: self._schedule(False),
            reset=lambda: self._schedule(True),
            is_canceled=lambda: not self.scheduled,
        )

    def _schedule(self, it_is: bool) -> None:
        self.scheduled = it_is

    def get_subscription_count(self) -> int:
        return self.listeners

    def get_clock(self) -> Any:
        return SimpleNamespace(now=lambda: SimpleNamespace(nanoseconds=self.now_s * 10**9))

    def publish(self, message: Any) -> None:
        self.told.append((message.stamp.sec, message.seq, message.disk_wait))


@pytest.fixture
def node(monkeypatch: pytest.MonkeyPatch) -> Clock:
    clock = Clock()
    monkeypatch.setattr(outputs, 'publisher', lambda *_: clock)
    monkeypatch.setattr(outputs, 'steady_timer', lambda *_: clock.timer)
    return clock


def make(node: Clock, engine: Any, beats: list[Callable[[], None]]) -> StatusTopic:
    overview = SimpleNamespace(status=lambda now_s, _: statuses.status(stamp=now_s))
    expected = SimpleNamespace(within_s=lambda _: {})
    pulse = SimpleNamespace(add=beats.append)
    uptime = MachineUptime().now
    return StatusTopic(node, engine, overview, expected, pulse, uptime)  # type: ignore[arg-type]


def test_only_what_the_journal_holds_is_told(node: Clock) -> None:
    engine = SimpleNamespace(awaits_disk=True, disk_wait='the last event')
    topic = make(node, engine, [])
    topic.publish_now()
    assert node.told == [], 'nothing is known that the journal holds'

    engine.awaits_disk = False
    topic.publish_now()
    engine.awaits_disk, node.now_s = True, 1001
    topic.publish_now()
    assert node.told == [(1000, 7, ''), (1001, 7, 'the last event')]


WORK, ORDER = e.BeltIndexed(beat=2), e.JobRemoved(job='WO-1')


@pytest.mark.parametrize(
    ('listeners', 'events', 'is_soon'),
    [(0, [WORK], False), (1, [WORK], True), (0, [WORK, ORDER], True)],
)
def test_ordinary_work_without_listeners_waits_for_next_second(
    node: Clock, listeners: int, events: list[e.Event], is_soon: bool
) -> None:
    beats: list[Callable[[], None]] = []
    topic = make(node, SimpleNamespace(awaits_disk=False, disk_wait=''), beats)
    node.listeners = listeners
    topic.publish(events)
    assert node.scheduled is is_soon
    for beat in beats:
        beat()
    assert bool(node.told) is not is_soon, 'what is scheduled comes by its own timer'
