"""Names of several servers, which the ROS graph learns a moment after what they serve (2.5)."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import pytest

from bt_orchestrator.ros.actions import rivals
from bt_orchestrator.ros.actions.rivals import UNNAMED, Rivals


@pytest.mark.parametrize('looks', [1, 2])
def test_2_5_unnamed_server_gets_its_name_later(
    monkeypatch: pytest.MonkeyPatch, looks: int
) -> None:
    monkeypatch.setattr(rivals, 'LOOK_S', 0.0)
    first, second = endpoint('press', 1), endpoint(UNNAMED, 2)
    status = SimpleNamespace(
        publishers=2, publishers_info=lambda: [first, second], own_endpoint=tuple
    )
    client = SimpleNamespace(status=status, count_servers=lambda: 2, count_takers=lambda: 2)
    clients = cast('Any', SimpleNamespace(current=client))
    several = Rivals(clients, fresh_node=lambda: cast('Any', None))
    for _ in range(looks):
        assert several.look() == ('/press', 'a node without name')
    second.node_name = 'copy_of_press'
    assert several.look() == ('/copy_of_press', '/press')
    first.node_name = UNNAMED
    assert several.look() == ('/copy_of_press', '/press'), 'a name that was known stays'


def test_2_5_status_of_second_server_shows_between_looks(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(rivals, 'LOOK_S', 60.0)
    both = [endpoint('press', 1), endpoint('copy_of_press', 2)]
    status = SimpleNamespace(publishers=1, publishers_info=lambda: both, own_endpoint=tuple)
    client = SimpleNamespace(
        status=status,
        count_servers=lambda: status.publishers,
        count_takers=lambda: status.publishers,
    )
    several = Rivals(cast('Any', SimpleNamespace(current=client)), lambda: cast('Any', None))
    assert several.look() == ()
    status.publishers = 2
    assert several.look() == ('/copy_of_press', '/press')


def endpoint(node: str, number: int) -> SimpleNamespace:
    return SimpleNamespace(node_name=node, node_namespace='/', endpoint_gid=bytes([number] * 16))
