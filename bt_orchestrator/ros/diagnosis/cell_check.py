"""Whether all that a cell file names is on the graph, and only once, and its tree node with it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from bt_orchestrator_interfaces.msg import Status
from rcl_interfaces.srv import GetParameters
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy
from rclpy.topic_endpoint_info import TopicEndpointInfo

from bt_orchestrator.base.diagnosis.check import Check, fail, ok, warn
from bt_orchestrator.model.by import Role
from bt_orchestrator.model.cell import Cell, Component, StateTopic
from bt_orchestrator.ros.actions.rivals import is_named, names, owner
from bt_orchestrator.ros.diagnosis.graph import Graph
from bt_orchestrator.ros.node_parameters import REQUIRED
from bt_orchestrator.ros.standby import TOPIC as STANDBY


def cell_on_graph(graph: Graph, cell: Cell, timeout_s: float, elsewhere: str) -> Iterator[Check]:
    """Look for the servers and state topics of all components.

    :param timeout_s: longest time to wait for what is missing
    :param elsewhere: what is known about other domains, for the hints
    """
    components = cell.components.values()
    graph.wait(lambda: all(_is_there(graph, component) for component in components), timeout_s)
    graph.settle()
    for component in components:
        yield _server(graph, component, elsewhere)
        if component.state is not None:
            yield _state(graph, component, component.state)


def _is_there(graph: Graph, component: Component) -> bool:
    groups = [graph.action_servers(component.action)]
    if component.state is not None:
        groups.append(graph.publishers(component.state.topic))
    return all(group and all(map(is_named, group)) for group in groups)


def _server(graph: Graph, component: Component, elsewhere: str) -> Check:
    name, action = f'{component.name}: action server', graph.full(component.action)
    servers = graph.action_servers(component.action)
    if not servers:
        remedy = f'{elsewhere}; ' if elsewhere else ''
        remedy += f'start its controller, in this domain and network, with the action {action}'
        return fail(name, f'none at {action}', remedy)
    types = sorted({server.topic_type.removesuffix('_FeedbackMessage') for server in servers})
    if types != [component.type]:
        remedy = 'correct `type` in the cell file, or the name of the action'
        what = f'{action} is {", ".join(types)} ({names(servers)}), not {component.type}'
        return fail(name, what, remedy)
    count = max(len(servers), graph.action_takers(component.action))
    if count > 1:
        remedy = 'every goal would go to all of them, so none is sent: stop all but one'
        others = ', and one without its topics' if count > len(servers) else ''
        return fail(name, f'{count} servers at {action}: {names(servers)}{others}', remedy)
    nodes = set(map(owner, servers))
    alone = [node for node in graph.publishers(f'{action}/_action/status') if is_named(node)]
    alone = [node for node in alone if owner(node) not in nodes]
    if alone:
        what = f'{names(alone)} publishes the status of {action} and takes no goals'
        return fail(name, what, 'it counts as a second server, so no goal is sent: stop it')
    return ok(name, f'{action} ({names(servers)})')


def _state(graph: Graph, component: Component, state: StateTopic) -> Check:
    name, topic = f'{component.name}: state topic', graph.full(state.topic)
    publishers = graph.publishers(state.topic)
    if not publishers:
        remedy = 'the component counts as not ready and gets no goal; start what publishes it'
        return fail(name, f'no node publishes {topic}', remedy)
    wrong = [publisher for publisher in publishers if publisher.topic_type != state.type]
    if wrong:
        what = f'{topic} is {wrong[0].topic_type} ({names(wrong)}), not {state.type}'
        return fail(name, what, 'correct `state: {type: ...}` in the cell file, or the publisher')
    if len(publishers) > 1:
        remedy = 'the last message of any of them counts: stop all but one if they may disagree'
        return warn(name, f'{len(publishers)} publishers of {topic}: {names(publishers)}', remedy)
    return _quality(name, topic, publishers)


def _quality(name: str, topic: str, publishers: Sequence[TopicEndpointInfo]) -> Check:
    """Judge the publishers' QoS: the node adapts to it, but cannot get what is not kept."""
    unreliable = [
        publisher
        for publisher in publishers
        if publisher.qos_profile.reliability is not ReliabilityPolicy.RELIABLE
    ]
    if unreliable:
        remedy = 'a change may get lost; let it publish RELIABLE and TRANSIENT_LOCAL, or often'
        return warn(name, f'{topic} is BEST_EFFORT at {names(unreliable)}', remedy)
    latched = DurabilityPolicy.TRANSIENT_LOCAL
    forgetful = [
        publisher for publisher in publishers if publisher.qos_profile.durability is not latched
    ]
    if forgetful:
        remedy = (
            'a node that starts later hears nothing until the next message, and waits; '
            'let it publish TRANSIENT_LOCAL (latched), or again and again'
        )
        return warn(name, f'{topic} is VOLATILE at {names(forgetful)}', remedy)
    return ok(name, f'{topic} ({names(publishers)})')


# Whether a tree node runs, alone under its name, and by which clock.

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
    standbys = len(graph.publishers(f'{node}/{STANDBY}'))
    count = graph.nodes().count(node) - standbys
    if standbys:
        yield ok('standby', f'{standbys} of {node} can take over, or wait until they can')
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
    if status is None or not role:
        return
    if status.signed_commands == REQUIRED:
        yield ok('role over ROS', 'only requests that a key has signed count (signed_commands)')
        return
    words = (
        f'unauthenticated: everybody in the ROS domain has the role {role} (unauthenticated_role)'
    )
    if role == Role.VIEW.value:
        remedy = 'every command over ROS is refused: give the node --unauthenticated-role, if'
        yield warn('role over ROS', words, f'{remedy} all who hear it may command it')
    else:
        yield ok('role over ROS', words)


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
