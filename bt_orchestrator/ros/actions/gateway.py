"""The robots, through ROS 2 actions and topics."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rclpy.node import Node
from rclpy.timer import Timer

from bt_orchestrator.model.cell import Cell, Component
from bt_orchestrator.model.goal import NOT_HEARD, SERVER_TIMEOUT_S, GoalRequest
from bt_orchestrator.ports import ActionTypes, Told
from bt_orchestrator.ports.news import News
from bt_orchestrator.ports.spare_log import guarded
from bt_orchestrator.ros.actions.action_link import ActionLink
from bt_orchestrator.ros.actions.fresh_participant import FreshParticipants
from bt_orchestrator.ros.actions.open_goals import Leave, RosGoal
from bt_orchestrator.ros.actions.state_watch import SafetyWatch, StateWatch
from bt_orchestrator.ros.executor.alarms import steady_timer
from bt_orchestrator.ros.executor.ways import Way
from bt_orchestrator.ros.types.interface_classes import action_class

_POLL_PERIOD_S = 0.1
"""Between two looks for a server that a goal waits for."""

_WATCH_PERIOD_S = 0.5
"""Between two looks at the goals in flight; what is due is done at the next look."""

_LOOK_PERIOD_S = 1.0
"""Between two looks at who serves the actions and who publishes the state topics."""


class RosGateway:
    """One action client and one state topic a component. Implements `ports.ActionGateway`.

    Everything, its own timers too, runs in the thread of the node's executor; `send` and `drain`
    are called there as well. Its timers use the steady clock: servers come and die in real time,
    whatever the simulated one does.
    """

    def __init__(
        self,
        node: Node,
        cell: Cell,
        types: ActionTypes,
        way: Way,
        *,
        server_timeout_s: float = SERVER_TIMEOUT_S,
    ) -> None:
        """Create clients and subscriptions.

        :param way: how the clients use rclpy

        :raises UnknownActionType: an action or message type of the cell is not installed
        """
        self._node = node
        self._news = News()
        self._types = types
        self._way = way
        self._server_timeout_s = server_timeout_s
        components = cell.components.values()
        self._fresh = FreshParticipants(node)
        self._leave = Leave()
        self._links = {component.name: self._link(component) for component in components}
        self._states = [
            StateWatch(node, component, component.state, self._news)
            for component in components
            if component.state is not None
        ]
        self.unsafe = '' if cell.safety is None else NOT_HEARD
        self._safety = (
            None
            if cell.safety is None
            else SafetyWatch(node, cell.safety, self._news, self._say_of_safety)
        )
        self._poll_timer = self._timer(_POLL_PERIOD_S, self._poll)
        self._poll_timer.cancel()
        self._watch_timer = self._timer(_WATCH_PERIOD_S, self._watch)
        self._has_looked = False
        look_timer = self._timer(_LOOK_PERIOD_S, self._look)
        self._timers = [self._poll_timer, self._watch_timer, look_timer]

    def obey(self, may_send: Callable[[], bool], alone_from_s: float) -> None:
        """Send goals only while this node may, and believe no denial from before it was alone.

        A goal that may not be sent waits, as for a server (semantics 9.4).

        :param may_send: asked before each goal
        :param alone_from_s: when no other node sends goals any more, by the monotonic clock
        """
        self._leave.may_send, self._leave.alone_from_s = may_send, alone_from_s

    def begin_anew(self) -> None:
        """Forget what came while another node led the cell, and report the present once more."""
        self._news.drain()
        self._has_looked = False
        for link in self._links.values():
            link.forget()
        for state in self._states:
            state.tell_again()

    def listen(self, wake: Callable[[], None]) -> None:
        """Name the function to call when there is something new; it is called in callbacks."""
        self._news.listen(wake)

    def prepare(self, request: GoalRequest) -> None:
        """Look for rivals, and make the message, of a goal that `send` may follow for."""
        self._links[request.component].prepare(request)

    def send(self, request: GoalRequest) -> RosGoal:
        """Send one goal."""
        link = self._links[request.component]
        goal = link.send(request)
        self._look_after(link)
        return goal

    def adopt(self, request: GoalRequest) -> RosGoal:
        """Take over a goal that an earlier process sent, by its UUID (semantics 9.2).

        Nothing is sent but questions for its result. It ends as the server says, or LOST if the
        server does not know it, or if there is no server within the server timeout, or SILENT if
        one is there and does not answer; it counts as accepted when the server's status says that
        it runs.
        """
        link = self._links[request.component]
        goal = link.adopt(request)
        self._look_after(link)
        return goal

    def drain(self) -> Sequence[Told]:
        """Return what is new."""
        if not self._has_looked:
            self._has_looked = True
            self._look()  # before anything is sent
        return self._news.drain()

    def available(self, component: str) -> bool:
        """Tell whether the component's server is in the ROS graph."""
        return self._links[component].available

    def rivals(self, component: str) -> Sequence[str]:
        """Return the servers of the component's action, if several are in the ROS graph."""
        return self._links[component].rivals

    def server(self, component: str) -> str | None:
        """Return the id of the status publisher of the component's server, seen last."""
        return self._links[component].server

    def close(self) -> None:
        """Destroy clients, subscriptions and timers; goals that run go on running."""
        for timer in self._timers:
            self._node.destroy_timer(timer)
        for state in self._states:
            state.close()
        if self._safety is not None:
            self._safety.close()
            self._safety = None
        for link in self._links.values():
            link.close()
        self._fresh.close()
        self._timers.clear()
        self._states.clear()
        self._links.clear()

    def _say_of_safety(self, unsafe: str) -> None:
        self.unsafe = unsafe

    def _link(self, component: Component) -> ActionLink:
        return ActionLink(
            self._node,
            component,
            action_class(component.type),
            self._types.action(component.type),
            self._news,
            self._server_timeout_s,
            self._fresh_node,
            self._leave,
            self._way,
        )

    def _fresh_node(self, kept_s: float) -> Node:
        self._fresh.keep({node for link in self._links.values() for node in link.nodes})
        return self._fresh.node(kept_s)

    def _timer(self, period_s: float, callback: Callable[[], None]) -> Timer:
        return steady_timer(self._node, period_s, guarded(callback, self._node.get_logger()))

    def _look_after(self, link: ActionLink) -> None:
        if link.is_waiting and self._poll_timer.is_canceled():
            self._poll_timer.reset()
        if self._watch_timer.is_canceled():
            self._watch_timer.reset()

    def _poll(self) -> None:
        for link in self._links.values():
            link.poll()
        if not any(link.is_waiting for link in self._links.values()):
            self._poll_timer.cancel()

    def _watch(self) -> None:
        for link in self._links.values():
            link.watch()
        if not any(link.is_open for link in self._links.values()):
            self._watch_timer.cancel()

    def _look(self) -> None:
        for link in self._links.values():
            seen = link.look()
            if seen is not None:
                self._news.add(seen)
        for state in self._states:
            state.look()
