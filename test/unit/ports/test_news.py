from __future__ import annotations

from bt_orchestrator.model.goal import GoalEnd, GoalRequest, GoalStatus, StateReading
from bt_orchestrator.ports.news import News
from bt_orchestrator.sim.virtual_client import VirtualGoal


def goal() -> VirtualGoal:
    return VirtualGoal(GoalRequest('id', 'arm', 'PICK'), lambda goal: None)


def test_oldest_first_and_once() -> None:
    news = News()
    first, second = goal(), goal()
    for entry in (first, second, first):
        news.add(entry)
    assert news.drain() == (second, first)
    assert news.drain() == ()


def test_equal_readings_are_two_readings() -> None:
    news = News()
    readings = [StateReading('arm', ['unhashable']), StateReading('arm', ['unhashable'])]
    for reading in readings:
        news.add(reading)
    assert list(news.drain()) == readings


def test_end_and_reading_wake_but_acceptance_does_not() -> None:
    news = News()
    seen: list[int] = []
    news.listen(lambda: seen.append(len(news.drain())))
    ended = goal()
    news.add(ended)
    assert seen == []
    ended.end = GoalEnd(GoalStatus.SUCCEEDED, {})
    news.add(ended)
    news.add(StateReading('arm', 'READY'))
    assert seen == [1, 1]
