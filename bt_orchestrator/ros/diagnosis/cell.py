"""Whether everything that a cell file names is on the graph, and only once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rclpy.qos import DurabilityPolicy, ReliabilityPolicy
from rclpy.topic_endpoint_info import TopicEndpointInfo

from bt_orchestrator.base.diagnosis.check import Check, fail, ok, warn
from bt_orchestrator.model.cell import Cell, Component, StateTopic
from bt_orchestrator.ros.actions.endpoints import is_named, names
from bt_orchestrator.ros.diagnosis.graph import Graph


def cell_on_graph(graph: Graph, cell: Cell, timeout_s: float, elsewhere: str) -> Iterator[Check]:
    """Look for the servers and state topics of all components.

    :param timeout_s: longest time to wait for what is missing
    :param elsewhere: what is known about other domains, for the hints
    """
    components = cell.components.values()
    graph.wait(lambda: all(_is_there(graph, one) for one in components), timeout_s)
    graph.settle()
    for component in components:
        yield _server(graph, component, elsewhere)
        if component.state is not None:
            yield _state(graph, component, component.state)


def _is_there(graph: Graph, component: Component) -> bool:
    found = [graph.action_servers(component.action)]
    if component.state is not None:
        found.append(graph.publishers(component.state.topic))
    return all(one and all(map(is_named, one)) for one in found)


def _server(graph: Graph, component: Component, elsewhere: str) -> Check:
    name, action = f'{component.name}: action server', graph.full(component.action)
    found = graph.action_servers(component.action)
    if not found:
        remedy = f'{elsewhere}; ' if elsewhere else ''
        remedy += f'start its controller, in this domain and network, with the action {action}'
        return fail(name, f'none at {action}', remedy)
    types = sorted({one.topic_type.removesuffix('_FeedbackMessage') for one in found})
    if types != [component.type]:
        remedy = 'correct `type` in the cell file, or the name of the action'
        what = f'{action} is {", ".join(types)} ({names(found)}), not {component.type}'
        return fail(name, what, remedy)
    count = max(len(found), graph.action_takers(component.action))
    if count > 1:
        remedy = 'every goal would go to all of them, so none is sent: stop all but one'
        others = ', and one without its topics' if count > len(found) else ''
        return fail(name, f'{count} servers at {action}: {names(found)}{others}', remedy)
    return ok(name, f'{action} ({names(found)})')


def _state(graph: Graph, component: Component, state: StateTopic) -> Check:
    name, topic = f'{component.name}: state topic', graph.full(state.topic)
    found = graph.publishers(state.topic)
    if not found:
        remedy = 'the component counts as not ready and gets no goal; start what publishes it'
        return fail(name, f'no node publishes {topic}', remedy)
    wrong = [one for one in found if one.topic_type != state.type]
    if wrong:
        what = f'{topic} is {wrong[0].topic_type} ({names(wrong)}), not {state.type}'
        return fail(name, what, 'correct `state: {type: ...}` in the cell file, or the publisher')
    if len(found) > 1:
        remedy = 'the last message of any of them counts: stop all but one if they may disagree'
        return warn(name, f'{len(found)} publishers of {topic}: {names(found)}', remedy)
    return _quality(name, topic, found)


def _quality(name: str, topic: str, found: Sequence[TopicEndpointInfo]) -> Check:
    """Judge the publishers' QoS: the node adapts to it, but cannot get what is not kept."""
    unreliable = [
        one for one in found if one.qos_profile.reliability is not ReliabilityPolicy.RELIABLE
    ]
    if unreliable:
        remedy = 'a change may get lost; let it publish RELIABLE and TRANSIENT_LOCAL, or often'
        return warn(name, f'{topic} is BEST_EFFORT at {names(unreliable)}', remedy)
    latched = DurabilityPolicy.TRANSIENT_LOCAL
    forgetful = [one for one in found if one.qos_profile.durability is not latched]
    if forgetful:
        remedy = (
            'a node that starts later hears nothing until the next message, and waits; '
            'let it publish TRANSIENT_LOCAL (latched), or again and again'
        )
        return warn(name, f'{topic} is VOLATILE at {names(forgetful)}', remedy)
    return ok(name, f'{topic} ({names(found)})')
