"""The owners of the endpoints of a topic, in words."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from rclpy.topic_endpoint_info import TopicEndpointInfo

from bt_orchestrator.ros.executor.handles import id_of

UNNAMED = '_NODE_NAME_UNKNOWN_'
"""As rmw writes it."""


def is_named(endpoint: TopicEndpointInfo) -> bool:
    """Tell whether it is known whose it is: that comes a moment after the endpoint itself."""
    return endpoint.node_name != UNNAMED


def endpoint_id(endpoint: TopicEndpointInfo) -> str:
    """Return an id that no other endpoint has."""
    return id_of(endpoint.endpoint_gid)


def owners(endpoints: Sequence[TopicEndpointInfo]) -> tuple[str, ...]:
    """Return the full names of the nodes; where names are equal, with the ids of the endpoints."""
    found = sorted((_owner(endpoint), endpoint_id(endpoint)) for endpoint in endpoints)
    count = Counter(name for name, _ in found)
    return tuple(name if count[name] == 1 else f'{name} (id {id_})' for name, id_ in found)


def names(endpoints: Sequence[TopicEndpointInfo]) -> str:
    """Return who they belong to, as one text."""
    return ', '.join(owners(endpoints))


def _owner(endpoint: TopicEndpointInfo) -> str:
    if not is_named(endpoint):
        return 'a node without name'
    return f'{endpoint.node_namespace.rstrip("/")}/{endpoint.node_name}'
