"""Our rules for ROS 2 names are those of ROS 2."""

from __future__ import annotations

import sys

import pytest
from rclpy.exceptions import InvalidTopicNameException
from rclpy.expand_topic_name import expand_topic_name
from rclpy.validate_full_topic_name import validate_full_topic_name

from bt_orchestrator.ros.link.client import NodeClient
from bt_orchestrator.script.report import START, Report
from bt_orchestrator.script.ros_names import LONGEST_TOPIC, check_topic_name

NAMES = (
    *('/a', 'a', '/a/b_2', 'a/B', '/_hidden/__x', '/a' + '/b' * 100, 'a__b', '/a_', '_'),
    *('/1a', '/a/1', '1', 'a//b', '/a/', '/', 'a-b', '/a b', 'ä', '/a.b', '/²', 'a/', '//'),
    '/' + 'a' * (LONGEST_TOPIC - 1),
    '/' + 'a' * LONGEST_TOPIC,
)


@pytest.mark.parametrize('name', NAMES)
def test_rclpy_agrees(name: str) -> None:
    try:
        validate_full_topic_name(expand_topic_name(name, 'node', '/'))
    except (InvalidTopicNameException, ValueError):
        is_legal = False
    else:
        is_legal = True
    assert check_topic_name(name, START, Report('a.yaml')) is is_legal


def test_clients_in_same_process_have_distinct_names(monkeypatch: pytest.MonkeyPatch) -> None:
    """A launch file renames each node of a process, with `__node` for the global arguments."""
    monkeypatch.setattr(sys, 'argv', ['page', '--ros-args', '-r', '__node:=page'])
    with NodeClient('/cell', 1.0) as first, NodeClient('/cell', 1.0) as other:
        assert first.node.get_fully_qualified_name() != other.node.get_fully_qualified_name()
