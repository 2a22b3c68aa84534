"""Which instance of a server publishes the status: the graph is asked while that may change."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import pytest

from bt_orchestrator.ros.actions import goal_client
from bt_orchestrator.ros.actions.goal_client import GRAPH_S, ServerStatus
from bt_orchestrator.ros.executor.ways import Connections


class Graph:
    """The ROS graph as one node sees it, and its subscription to the status."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.publishers = [1]
        self.connections: Connections | None = Connections(1, 1)
        self.looks = 0
        self.now_s = 100.0
        clock = SimpleNamespace(monotonic=lambda: self.now_s)
        monkeypatch.setattr(goal_client, 'time', clock)
        way = cast('Any', SimpleNamespace(last_message=lambda *_: self))
        self.status = ServerStatus(cast('Any', self), '/press', way)

    def get_publishers_info_by_topic(self, _: str) -> list[SimpleNamespace]:
        self.looks += 1
        return [SimpleNamespace(endpoint_gid=bytes([number])) for number in self.publishers]

    def id_after(self, seconds: float) -> str | None:
        self.now_s += seconds
        return self.status.publisher_id()


@pytest.fixture
def graph(monkeypatch: pytest.MonkeyPatch) -> Graph:
    return Graph(monkeypatch)


def test_known_server_is_looked_up_until_graph_settles(graph: Graph) -> None:
    assert [graph.id_after(GRAPH_S / 2) for _ in range(8)] == ['01'] * 8
    assert graph.looks == 4


def test_replacing_server_is_seen_despite_stale_graph(
    graph: Graph,
) -> None:
    graph.id_after(2 * GRAPH_S), graph.id_after(2 * GRAPH_S)
    graph.connections = Connections(2, 1)
    assert graph.id_after(GRAPH_S / 2) == '01', 'the graph does not know it yet'
    graph.publishers = [1, 2]
    assert graph.id_after(GRAPH_S) is None
    graph.publishers = [2]
    assert graph.id_after(GRAPH_S) == '02'


def test_graph_with_too_many_servers_is_asked_again(graph: Graph) -> None:
    graph.publishers = [1, 2]
    assert [graph.id_after(2 * GRAPH_S) for _ in range(3)] == [None] * 3
    graph.publishers = [1]
    assert graph.id_after(GRAPH_S) == '01'


def test_unknown_connection_count_forces_lookup_each_time(graph: Graph) -> None:
    graph.connections = None
    assert [graph.id_after(2 * GRAPH_S) for _ in range(3)] == ['01'] * 3
    assert graph.looks == 3
