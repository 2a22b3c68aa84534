"""The action servers on the ROS graph."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.ros.actions.endpoints import names
from bt_orchestrator.ros.diagnosis.graph import SETTLE_S, Graph
from bt_orchestrator.script.starter.starter_plan import FoundServer

_FEEDBACK = '/_action/feedback'
_FEEDBACK_TYPE = '_FeedbackMessage'
_STATE_TYPE = 'std_msgs/msg/String'

_NO_DEVICE = 'bt_orchestrator_interfaces/action/RunJob'
"""The services of a tree node that runs beside the controllers."""


class NobodyServes(OrchestratorError):
    """There is no action server on the graph."""


def find_action_servers(timeout_s: float) -> Sequence[FoundServer]:
    """Join the ROS graph for a moment and return its action servers.

    :param timeout_s: longest time to wait for a first one, and for the last one
    :raises NobodyServes: none was found
    """
    with Graph('/') as graph:
        look = _Look(graph)
        graph.wait(look.is_settled, timeout_s)
    if not look.found:
        raise NobodyServes(
            f'no action server was found within {timeout_s:g} s; start the controllers, with this '
            'ROS_DOMAIN_ID, or leave out --from-graph'
        )
    return look.found


class _Look:
    """The content of the graph, and its time."""

    def __init__(self, graph: Graph) -> None:
        self._graph = graph
        self._since = time.monotonic()
        self.found: list[FoundServer] = []

    def is_settled(self) -> bool:
        """Look again; tell whether there is something, and nothing new for a while."""
        found = [*_servers(self._graph)]
        if found != self.found:
            self.found, self._since = found, time.monotonic()
        return bool(found) and time.monotonic() > self._since + SETTLE_S


def _servers(graph: Graph) -> Iterator[FoundServer]:
    """Yield who publishes feedback: node names do not tell two nodes of one name apart."""
    topics = graph.topics()
    states = [name for name, types in topics.items() if _STATE_TYPE in types]
    for topic in sorted(topics):
        action = topic.removesuffix(_FEEDBACK)
        served = graph.action_servers(action) if action != topic else ()
        type_name = served[0].topic_type.removesuffix(_FEEDBACK_TYPE) if served else _NO_DEVICE
        if type_name != _NO_DEVICE:
            yield FoundServer(action, type_name, names(served), _beside(action, states))


def _beside(action: str, topics: Sequence[str]) -> tuple[str, ...]:
    """Return the topics of an action's own namespace that are called state or status."""
    folder = action.rpartition('/')[0]
    likely = (f'{folder}/{word}' for word in ('state', 'status') if folder)
    return tuple(topic for topic in likely if topic in topics)
