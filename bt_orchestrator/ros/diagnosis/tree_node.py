"""Whether a tree node runs, alone under its name, and by which clock."""

from __future__ import annotations

from collections.abc import Iterator

from bt_orchestrator_interfaces.msg import Status
from rcl_interfaces.srv import GetParameters

from bt_orchestrator.base.diagnosis.check import Check, fail, ok, warn
from bt_orchestrator.model.roles import Role
from bt_orchestrator.ros.actions.endpoints import names
from bt_orchestrator.ros.diagnosis.graph import Graph

CLOCK = '/clock'


def tree_node(graph: Graph, node: str, *, expected: bool, timeout_s: float) -> Iterator[Check]:
    """Look for a tree node.

    :param node: its full name
    :param expected: whether it is a fault that it does not run
    """
    graph.settle()
    # Its name may become known later than its topics.
    if expected or graph.publishers(f'{node}/status'):
        graph.wait(lambda: node in graph.nodes(), timeout_s)
    count = graph.nodes().count(node)
    if count > 1:
        remedy = 'stop all but one, or give each a --namespace: clients would reach either'
        words = graph.twins(node) or f'{count} nodes are called {node}'
        yield fail('tree node', words, remedy)
    elif count:
        yield ok('tree node', f'{node} runs')
        yield from _role(graph, node, timeout_s)
    elif expected:
        remedy = 'start it (bt-orchestrator run), in this domain, or name another one with --node'
        yield fail('tree node', f'no node {node}', remedy)
    else:
        yield ok('tree node', f'no {node} runs; nothing is in the way of one')
    yield _clock(graph, node if count else None, timeout_s)


def _role(graph: Graph, node: str, timeout_s: float) -> Iterator[Check]:
    """Say what any client may request of the node: ROS does not authenticate clients."""
    topic = f'{node}/status'
    status = graph.latched(Status, topic, timeout_s) if graph.publishers(topic) else None
    role = '' if status is None else status.unauthenticated_role
    if not role:
        return
    found = f'everybody in the ROS domain has the role {role} (unauthenticated_role)'
    if role == Role.VIEW.value:
        remedy = 'every command over ROS is refused: give the node --unauthenticated-role, if'
        yield warn('role over ROS', found, f'{remedy} all who hear it may command it')
    else:
        yield ok('role over ROS', found)


def _clock(graph: Graph, node: str | None, timeout_s: float) -> Check:
    clocks = graph.publishers(CLOCK)
    if len(clocks) > 1:
        remedy = 'time would jump to and fro: stop all but one'
        return fail('clock', f'{len(clocks)} publishers of {CLOCK}: {names(clocks)}', remedy)
    uses = node is not None and _uses_sim_time(graph, node, timeout_s)
    if uses and not clocks:
        remedy = 'its time stands still; start what publishes it, or set use_sim_time false'
        return fail('clock', f'{node} has use_sim_time, but no node publishes {CLOCK}', remedy)
    if uses:
        return ok('clock', f'{node} follows {CLOCK} ({names(clocks)})')
    there = f'; {names(clocks)} publishes {CLOCK}, for nodes with use_sim_time' if clocks else ''
    return ok('clock', f'of the computer{there}')


def _uses_sim_time(graph: Graph, node: str, timeout_s: float) -> bool:
    request = GetParameters.Request(names=['use_sim_time'])
    response = graph.call(GetParameters, f'{node}/get_parameters', request, timeout_s)
    return response is not None and any(value.bool_value for value in response.values)
