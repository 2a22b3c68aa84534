from __future__ import annotations

from bt_orchestrator.model.goal import GoalRequest, StateReading
from bt_orchestrator.news import News
from bt_orchestrator.sim.virtual_goal import VirtualGoal


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


def test_wakes_at_every_addition() -> None:
    news = News()
    seen: list[int] = []
    news.add(goal())
    news.listen(lambda: seen.append(len(news.drain())))
    news.add(goal())
    news.add(goal())
    assert seen == [2, 1]
