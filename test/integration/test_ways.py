"""Which way the node uses rclpy: its inside where that is known, or what rclpy promises."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from action_msgs.srv import CancelGoal
from patience import until
from rclpy.context import Context
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.node import Node

from bt_orchestrator.ros.executor import lean_parts
from bt_orchestrator.ros.executor.lean_executor import LeanExecutor
from bt_orchestrator.ros.executor.ways import (
    PlainLastMessage,
    Service,
    Way,
    choose_way,
    plain_clients,
)
from bt_orchestrator.ros.node_parameters import AUTO, PLAIN

pytestmark = pytest.mark.every_distro

PLAIN_WAY = Way(SingleThreadedExecutor, plain_clients, PlainLastMessage)


class Warnings:
    """Takes the place of a node's logger."""

    def __init__(self) -> None:
        self.said: list[str] = []

    def warning(self, text: str) -> None:
        self.said.append(text)


@pytest.fixture
def node(context: Context) -> Iterator[Node]:
    node = Node('ways', context=context)
    yield node
    node.destroy_node()


@pytest.fixture
def warned(node: Node, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    warnings = Warnings()
    monkeypatch.setattr(node, 'get_logger', lambda: warnings)
    return warnings.said


def test_the_inside_of_this_rclpy_is_known(node: Node, warned: list[str]) -> None:
    digests = {name: lean_parts.digest(source) for name, source in lean_parts.sources().items()}
    strange = {name: sha for name, sha in digests.items() if sha not in lean_parts.KNOWN[name]}
    assert strange == {}, 'read what has changed, run test_executors.py, and add it to KNOWN'
    assert choose_way(AUTO, node).executor is LeanExecutor
    assert warned == []


@pytest.mark.parametrize('client', [AUTO, PLAIN])
def test_service_servers_are_counted_by_full_name(client: str, node: Node) -> None:
    (asked,), end = choose_way(client, node).clients(
        node, node.get_logger(), [Service(CancelGoal, '~/cancel')]
    )
    assert asked.servers() == 0
    for number in (1, 2):
        node.create_service(CancelGoal, 'ways/cancel', lambda _, response: response)
        until(lambda: asked.servers() == number, f'{number} of them')  # noqa: B023
    end()


def test_plain_way_is_taken_silently_on_request(node: Node, warned: list[str]) -> None:
    assert choose_way(PLAIN, node) == PLAIN_WAY
    assert warned == []


def another_source(node: Node, patch: pytest.MonkeyPatch) -> str:
    patch.setattr(Executor, '_take_client', lambda self, client: None)
    return 'Executor._take_client'


def a_method_less(node: Node, patch: pytest.MonkeyPatch) -> str:
    patch.delattr(Executor, '_take_timer')
    return 'Executor._take_timer'


def a_handle_less(node: Node, patch: pytest.MonkeyPatch) -> str:
    class Inside:
        Client = WaitSet = Subscription = InvalidHandle = object

    patch.setattr(lean_parts, '_rclpy', Inside)
    return 'Client.destroy_when_not_in_use'


def another_list(node: Node, patch: pytest.MonkeyPatch) -> str:
    patch.setattr(node, '_timers', ())
    return 'Node._timers'


def no_sources(node: Node, patch: pytest.MonkeyPatch) -> str:
    def getsource(_: Any) -> str:
        raise OSError('could not get source code')

    patch.setattr(inspect, 'getsource', getsource)
    return 'OSError: could not get source code'


@pytest.mark.parametrize(
    'change', [another_source, a_method_less, a_handle_less, another_list, no_sources]
)
def test_another_inside_is_left_alone_with_one_warning(
    node: Node,
    warned: list[str],
    monkeypatch: pytest.MonkeyPatch,
    change: Callable[[Node, pytest.MonkeyPatch], str],
) -> None:
    with monkeypatch.context() as patch:
        what = change(node, patch)
        assert choose_way(AUTO, node) == PLAIN_WAY
    [warning] = warned
    assert f'than the one that is known ({what})' in warning


def test_failed_import_of_lean_parts_selects_plain_way(
    node: Node, warned: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def import_module(name: str) -> None:
        raise ImportError(f'no {name}')

    monkeypatch.setattr(importlib, 'import_module', import_module)
    assert choose_way(AUTO, node) == PLAIN_WAY
    [warning] = warned
    assert 'ImportError: no bt_orchestrator.ros.executor.lean_parts' in warning
