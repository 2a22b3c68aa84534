"""Talking to a running tree node: calls, the latched status, the event stream."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any, NamedTuple
from uuid import uuid4

import rclpy
from bt_orchestrator_interfaces.msg import CellDescription as CellDescription_
from bt_orchestrator_interfaces.msg import Event, Status
from bt_orchestrator_interfaces.srv import GetEvents
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from bt_orchestrator.base.errors import NodeUnreachable
from bt_orchestrator.model.status import CellDescription, CellStatus
from bt_orchestrator.ros.identity import LOOK_S, TOPIC, Listener, twins_in_words
from bt_orchestrator.ros.qos import EVENTS, LATCHED, create_client
from bt_orchestrator.ros.types.status_messages import cell_description, cell_status

STEP_S = 0.1
"""Longest time between two looks at whether to stop waiting."""


class NodeClient:
    """A client of one tree node. A context: entering joins the ROS graph, leaving leaves it."""

    def __init__(
        self,
        node: str,
        timeout_s: float,
        meanwhile: Callable[[], object] | None = None,
        answer_s: float | None = None,
    ) -> None:
        """Prepare a client.

        :param node: the tree node's full name, for instance /bt_orchestrator
        :param timeout_s: longest time to wait for the node and for each of its answers
        :param meanwhile: called again and again while it waits; what it raises ends the waiting
        :param answer_s: longest time to wait for an answer, if it is longer
        """
        self._answer_s = timeout_s if answer_s is None else max(answer_s, timeout_s)
        self._name = '/' + node.strip('/')
        self._timeout_s = timeout_s
        self._meanwhile = meanwhile
        self._on_status: list[Callable[[CellStatus], object]] = []
        self._newest: Status | None = None
        """Came and was not handed on."""
        self._told: CellStatus | None = None

    def __enter__(self) -> NodeClient:
        # One of its own: a process may look at several nodes.
        self._context = Context()
        rclpy.init(context=self._context, signal_handler_options=SignalHandlerOptions.NO)
        # A launch file's name for the process would be the name of each of its nodes.
        self._node = Node(
            f'bt_orchestrator_client_{uuid4().hex[:8]}',
            context=self._context,
            use_global_arguments=False,
            start_parameter_services=False,
            enable_rosout=False,
        )
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self._node)
        self._identities = Listener(self._node, f'{self._name}/{TOPIC}')
        return self

    def __exit__(self, kind: object, *exception: object) -> None:
        if kind is None:
            self._tell_of_twins()
        self._identities.close()
        self._executor.shutdown()
        self._node.destroy_node()
        self._context.try_shutdown()

    def _tell_of_twins(self) -> None:
        """Say so if several nodes answer: who asks hears one of them, and commands reach all."""
        listener = self._identities
        heard = listener.listen(lambda heard: listener.publishers <= len(heard), LOOK_S)
        # One that was heard a while ago may be gone.
        words = twins_in_words(self._node, self._name) if len(heard) > 1 else ''
        if words:
            sys.stderr.write(f'{words}\n')

    @property
    def name(self) -> str:
        """Full name of the tree node."""
        return self._name

    @property
    def node(self) -> Node:
        """The client's own node."""
        return self._node

    def call(self, kind: Any, service: str, request: Any | Callable[[Status], Any]) -> Any:
        """Call one of the node's services and return its response.

        :param request: or what makes it of the status that the node has just told
        :raises NodeUnreachable: it is not there, or does not answer
        """
        client = self.service(kind, service)
        try:
            self.wait_until(client.service_is_ready, f'the service {self._name}/{service}')
            status = self._be_known()
            future = client.call_async(request(status) if callable(request) else request)
            what = f'an answer of {self._name}/{service}'
            self.wait_until(future.done, what, self._answer_s)
            return future.result()
        finally:
            self._node.destroy_client(client)

    def service(self, kind: Any, service: str) -> Any:
        """Return a client of one of the node's services."""
        return create_client(self._node, kind, f'{self._name}/{service}')

    def status(self) -> CellStatus:
        """Return how the cell stands, as the node has told last.

        :raises NodeUnreachable: nothing came
        """
        return cell_status(self._latched(Status, 'status'))

    def description(self) -> CellDescription:
        """Return what exists in the cell.

        :raises NodeUnreachable: nothing came
        """
        return cell_description(self._latched(CellDescription_, 'cell'))

    def on_status(self, callback: Callable[[CellStatus], object]) -> None:
        """Call back with the status of now, and with the newest one after each `spin`."""
        if not self._on_status:
            self._subscribe(Status, 'status', self._heard)
        elif self._told is not None:
            callback(self._told)
        self._on_status.append(callback)

    def _heard(self, message: Status) -> None:
        self._newest = message

    def _tell(self) -> None:
        """Hand on the newest status: those before it are void, and are not even read."""
        message, self._newest = self._newest, None
        if message is not None:
            self._told = cell_status(message)
            for callback in self._on_status:
                callback(self._told)

    def on_event(self, callback: Callable[[Any], None]) -> None:
        """Call back with every event from now on; returns when the node is connected.

        :raises NodeUnreachable: it is not there
        """
        self._node.create_subscription(Event, f'{self._name}/events', callback, EVENTS)
        self._be_known()

    def _be_known(self) -> Status:
        """Wait until the node knows all that this client has made so far; return its status.

        That a service or a topic is seen here does not say so: an answer or an event may still
        have nowhere to go. The node learns of what others made in their order, so once it sends
        the latched status to one more subscription, it knows what came before.
        """
        return self._latched(Status, 'status')

    def _latched(self, kind: Any, topic: str) -> Any:
        """Return the last message of a latched topic.

        :raises NodeUnreachable: none came
        """
        received: list[Any] = []
        subscription = self._subscribe(kind, topic, received.append)
        try:
            self.wait_until(lambda: bool(received), f'the {topic} of {self._name}')
            return received[-1]
        finally:
            self._node.destroy_subscription(subscription)

    def _subscribe(self, kind: Any, topic: str, callback: Callable[[Any], None]) -> Any:
        return self._node.create_subscription(kind, f'{self._name}/{topic}', callback, LATCHED)

    def wait_until(
        self, condition: Callable[[], bool], what: str, within_s: float | None = None
    ) -> None:
        """Spin until a condition holds.

        :param within_s: None: the time-out
        :raises NodeUnreachable: it does not within the time-out; names `what` was waited for
        """
        within_s = self._timeout_s if within_s is None else within_s
        deadline = time.monotonic() + within_s
        while not condition():
            if time.monotonic() > deadline:
                raise NodeUnreachable(
                    f'{what} did not come within {within_s:g} s; is the tree node running '
                    '(bt-orchestrator run), with this ROS_DOMAIN_ID and name?'
                )
            self.spin()

    def spin(self, within_s: float = STEP_S) -> None:
        """Handle what comes within a time, and within STEP_S."""
        self._executor.spin_once(timeout_sec=min(within_s, STEP_S))
        self._tell()
        if self._meanwhile is not None:
            self._meanwhile()


# Fetching events from the node's journal in the background.

GIVEN_UP_S = 5.0
"""After so long without an answer the request or the answer is lost."""


class _Fetch(NamedTuple):
    future: Any
    """None: there was no service to ask."""
    until: float


class EventFetches:
    """Requests to `~/get_events` that are under way, at most one for each reader."""

    def __init__(self, client: NodeClient) -> None:
        """Prepare; the node knows of it once it knows what `client` makes after it."""
        self._client = client
        self._service = client.service(GetEvents, 'get_events')
        self._pending: dict[object, _Fetch] = {}

    def begin(self, reader: object, after_seq: int) -> None:
        """Ask for the events after one."""
        future = None
        if self._service.service_is_ready():
            future = self._service.call_async(GetEvents.Request(after_seq=after_seq))
        self._pending[reader] = _Fetch(future, time.monotonic() + GIVEN_UP_S)

    @property
    def has_any(self) -> bool:
        """Tell whether an answer is there."""
        return any(
            fetch.future is not None and fetch.future.done() for fetch in self._pending.values()
        )

    def take(self, reader: object) -> Any:
        """Return the answer that is there for a reader; None: there is none."""
        fetch = self._pending.get(reader)
        if fetch is None or fetch.future is None or not fetch.future.done():
            return None
        del self._pending[reader]
        return fetch.future.result()

    def is_given_up(self, reader: object) -> bool:
        """Tell, once, that no answer will come."""
        fetch = self._pending.get(reader)
        if fetch is None or (fetch.future is not None and time.monotonic() < fetch.until):
            return False
        if fetch.future is not None:
            self._service.remove_pending_request(fetch.future)
        del self._pending[reader]
        return True
