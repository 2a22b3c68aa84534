"""What is told of the cell while the disk is waited for."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from fakes import statuses

from bt_orchestrator.ros.services import outputs
from bt_orchestrator.ros.services.outputs import StatusTopic


class Clock:
    """A node's clock, its publisher and its timer."""

    def __init__(self) -> None:
        self.now_s = 1000
        self.told: list[tuple[int, int, str]] = []
        self.timer = SimpleNamespace(cancel=lambda: None, reset=lambda: None)

    def get_clock(self) -> Any:
        return SimpleNamespace(now=lambda: SimpleNamespace(nanoseconds=self.now_s * 10**9))

    def publish(self, message: Any) -> None:
        self.told.append((message.stamp.sec, message.seq, message.disk_wait))


def test_only_what_the_journal_holds_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    node = Clock()
    monkeypatch.setattr(outputs, 'publisher', lambda *_: node)
    monkeypatch.setattr(outputs, 'steady_timer', lambda *_: node.timer)
    engine = SimpleNamespace(awaits_disk=True, disk_wait='the last event')
    overview = SimpleNamespace(status=lambda now_s, _: statuses.status(stamp=now_s))
    expected = SimpleNamespace(within_s=lambda _: {})
    pulse = SimpleNamespace(add=lambda _: None)
    topic = StatusTopic(node, engine, overview, expected, pulse)  # type: ignore[arg-type]
    topic.publish_now()
    assert node.told == [], 'nothing is known that the journal holds'

    engine.awaits_disk = False
    topic.publish_now()
    engine.awaits_disk, node.now_s = True, 1001
    topic.publish_now()
    assert node.told == [(1000, 7, ''), (1001, 7, 'the last event')]
