"""State topics that say too much: the journal stays small, and readiness is known (2.5)."""

from __future__ import annotations

import itertools
from typing import Any

import pytest

from bt_orchestrator.model.codec import json_of
from bt_orchestrator.ros.actions import state_watch
from bt_orchestrator.ros.actions.state_watch import SetupFlow, StateFlow

READY = 'READY'
LONG = 'x' * 64_000


class Topic:
    """A topic that says something each millisecond, and what is told of it."""

    def __init__(self, flow: StateFlow | None = None) -> None:
        self.flow = flow or StateFlow((READY,))
        self.now = 0.0
        self.told: list[Any] = []

    def say(self, *values: Any) -> None:
        for value in values:
            self.now += 0.001
            self.told += self.flow.hear(value, self.now)

    def wait(self, seconds: float) -> None:
        for _ in range(round(seconds * 10)):
            self.now += 0.1
            self.told += self.flow.look(self.now)

    @property
    def bytes(self) -> int:
        return sum(len(json_of(value)) + 200 for value in self.told)


def test_each_change_of_an_ordinary_topic_is_told() -> None:
    topic = Topic()
    values = ['BUSY', READY] * 50
    topic.say(*values)
    assert topic.told == values


def test_what_is_said_again_is_told_once() -> None:
    topic = Topic()
    topic.say(READY, READY, 1, True, True)
    assert topic.told == [READY, 1, True]


def test_frequent_long_values_are_reported_at_intervals() -> None:
    topic = Topic()
    for number in range(60_000):
        topic.say(f'{number} {LONG}')
    assert topic.bytes < 128_000 + 60 * 2_000 + 1_000
    assert len(topic.told) > 60


def test_long_value_is_serialised_only_if_reported(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    written = 0

    def count(value: Any) -> str:
        nonlocal written
        written += 1
        return json_of(value)

    monkeypatch.setattr(state_watch, 'json_of', count)
    topic = Topic()
    topic.say(*(f'{n} {LONG}' for n in range(2_000)))
    assert written <= 2 * len(topic.told)


def test_frequent_short_values_are_reported_at_intervals() -> None:
    topic = Topic()
    topic.say(*range(60_000))
    assert topic.bytes < 128_000 + 60 * 2_000 + 1_000


def test_newest_value_is_reported_as_soon_as_allowed() -> None:
    topic = Topic()
    topic.say(*range(5_000), READY)
    assert topic.told[-1] != READY
    topic.wait(1.0)
    assert topic.told[-1] == READY
    assert not topic.flow.is_waiting


def test_loss_of_readiness_is_reported_at_once() -> None:
    topic = Topic()
    for _ in range(30):
        topic.say(*itertools.chain.from_iterable((f'{n} {LONG}', READY) for n in range(100)))
        topic.wait(1.0)
        assert topic.told[-1] == READY
        topic.say(LONG)
        assert topic.told[-1] != READY
    assert topic.bytes < 128_000 + 33 * 2_000 + 30 * 2_000


def test_a_value_that_is_too_long_is_cut() -> None:
    topic = Topic()
    topic.say(READY, 'x' * 1_000_000, [1.5] * 100_000)
    assert topic.told[1].endswith('x … (1000000 characters, the rest is cut)')
    assert len(topic.told[1]) == 64_000
    assert topic.told[2] == '… (800002 bytes, too long to be shown)'


def test_a_topic_that_is_silent_is_told() -> None:
    topic = Topic()
    topic.say(READY, None, READY)
    assert topic.told == [READY, None, READY]


def test_a_setup_that_ends_is_told_at_once() -> None:
    topic = Topic(SetupFlow(('small', 'large')))
    for _ in range(2_000):
        topic.say('small', 'large')
    values = topic.told
    assert topic.told[-1] == '', 'neither is known for certain'
    assert len(values) < 1_000
    topic.say('small')
    topic.wait(1.0)
    assert topic.told[-1] == 'small'
    assert not topic.flow.is_waiting
