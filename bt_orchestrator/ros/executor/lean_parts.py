"""The lean way: parts of action clients as rclpy has them inside.

Only this and `lean_executor` know rclpy's inside; `ways.py` asks here whether it is the
one that is known.
"""

from __future__ import annotations

import hashlib
import inspect
from collections.abc import Callable, Sequence, Sized
from functools import partial
from typing import Any, Protocol

from rclpy.event_handler import UnsupportedEventTypeError
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.guard_condition import GuardCondition
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.type_support import check_for_type_support
from rclpy.waitable import NumberOfEntities, Waitable

from bt_orchestrator.ports.spare_log import Logger, report
from bt_orchestrator.ros.executor.ways import Answered, Connections, Service
from bt_orchestrator.ros.qos import SERVICES

# A topic whose last message only is read, and only on demand.


class LeanLastMessage:
    """A subscription outside the wait set: its last message stays until it is read."""

    def __init__(self, node: Node, message_class: Any, topic: str, qos: QoSProfile) -> None:
        """Subscribe; the topic's name is remapped as any other.

        :param qos: of depth 1
        """
        check_for_type_support(message_class)
        self._class = message_class
        profile: Any = qos.get_c_qos_profile()
        with node.handle:
            self._handle: Any = _rclpy.Subscription(node.handle, message_class, topic, profile)
        self._matched = _matched(self._handle)
        self._last: Any = None

    @property
    def publishers(self) -> int:
        """How many are connected; costs next to nothing."""
        with self._handle:
            return int(self._handle.get_publisher_count())

    @property
    def connections(self) -> Connections | None:
        """How many are and were connected, at this moment: the event waits for no turn."""
        if self._matched is None:
            return None
        with self._matched:
            matched = self._matched.take_event()
        return Connections(matched.total_count, matched.current_count)

    def read(self) -> Any:
        """Return the last message, the same one again until another came; None: none came."""
        with self._handle:
            taken = self._handle.take_message(self._class, False)
        if taken is not None:  # of depth 1: it was the only one
            self._last = taken[0]
        return self._last

    def destroy(self) -> None:
        """End the subscription."""
        if self._matched is not None:
            self._matched.destroy_when_not_in_use()
        self._handle.destroy_when_not_in_use()


def _matched(subscription: Any) -> Any:
    """Return the event of a subscription that tells its publishers; None: there is none."""
    try:
        return _rclpy.EventHandle(
            subscription, _rclpy.rcl_subscription_event_type_t.RCL_SUBSCRIPTION_MATCHED
        )
    except UnsupportedEventTypeError:  # of this middleware
        return None


# A service client that calls back in the turn in which an answer came.

Call = tuple[Callable[[Any], None], Any]
"""A callback, and what it is called with."""


class LeanQuestion:
    """A request that was sent. States: open, then answered or dropped."""

    __slots__ = ('_open', '_sequence')

    def __init__(self, open_ones: dict[int, Answered], sequence: int) -> None:
        self._open = open_ones
        self._sequence = sequence

    @property
    def is_open(self) -> bool:
        """Tell whether the answer is still waited for."""
        return self._sequence in self._open

    def drop(self) -> None:
        """Wait for the answer no longer; it may never come."""
        self._open.pop(self._sequence, None)


class LeanQuestions:
    """One service, and the questions that are open at it.

    rclpy's own client keeps a future for each, and lets the executor make a turn of its callback.
    """

    def __init__(self, node: Node, service: Service) -> None:
        """Make the client; its name is remapped as any other."""
        self._response = service.kind.Response
        self._is_last = service.is_last
        self._open: dict[int, Answered] = {}
        self.handle = _client(node, service)
        self._node = node.handle
        self._name = node.resolve_service_name(service.name)

    def __len__(self) -> int:
        return len(self._open)

    @property
    def awaited(self) -> Sized:
        """Return the questions that are open. Other answers are dropped with the next."""
        return self._open

    def ask(self, request: Any, answered: Answered) -> LeanQuestion:
        """Send a request.

        :param answered: called with each response up to the last one
        """
        sequence = self._send(request)
        self._open[sequence] = answered
        return LeanQuestion(self._open, sequence)

    def tell(self, request: Any) -> None:
        """Send a request whose answer does not matter."""
        self._send(request)

    def is_served(self) -> bool:
        """Tell whether the service is there; goes through the whole ROS graph twice."""
        with self.handle:
            return bool(self.handle.service_server_is_available())

    def servers(self) -> int:
        """Count those who serve it; goes through the whole ROS graph.

        rclpy's node takes three times as long: it makes the full name anew each time.
        """
        with self._node:
            return int(self._node.get_count_services(self._name))

    def take(self) -> Sequence[Call]:
        """Take the answers that have come, each with what is to be called.

        One at least, and more as long as questions are open: to hear from the middleware that
        there is no more takes as long as an answer. What else has come is for a later turn.
        """
        calls: list[Call] = []
        while True:
            with self.handle:
                header, response = self.handle.take_response(self._response)
            if header is None:
                return calls
            answered = self._asked(header.request_id.sequence_number, response)
            if answered is not None:
                calls.append((answered, response))
            if not self._open:
                return calls

    def _send(self, request: Any) -> int:
        with self.handle:
            return int(self.handle.send_request(request))

    def _asked(self, sequence: int, response: Any) -> Answered | None:
        """Return what is to be called with a response; the last one closes the question."""
        if self._is_last(response):
            return self._open.pop(sequence, None)
        return self._open.get(sequence)


def _client(node: Node, service: Service) -> Any:
    """Return a client's handle: used within `with`, and destroyed when not in use."""
    check_for_type_support(service.kind)
    profile: Any = SERVICES.get_c_qos_profile()
    with node.handle:
        return _rclpy.Client(node.handle, service.kind, service.name, profile)


# A waitable that names its parts: an executor need not ask it after each wait.


class Part(Protocol):
    """A service client."""

    @property
    def handle(self) -> Any:
        """The client as rclpy has it inside."""

    @property
    def awaited(self) -> Sized:
        """Return what holds the questions that are open: always the same. Empty: none are."""

    def take(self) -> Sequence[Call]:
        """Take all that came, each with what is to be called."""


class PartedWaitable(Waitable):  # type: ignore[type-arg] # no Generic in Jazzy's rclpy
    """Several service clients that run together, in plain calls.

    `LeanExecutor` waits for the parts and calls `note_ready` and `run`; rclpy's executors get the
    same through the interface of its waitables. What a callback raises is reported.

    :ivar parts: do not change
    """

    def __init__(self, node: Node, logger: Logger, parts: Sequence[Part]) -> None:
        super().__init__(node.default_callback_group)
        self.parts = tuple(parts)
        self._logger = logger
        self._places: Sequence[tuple[Part, int]] = ()
        self._ready: Sequence[Part] = ()
        node.add_waitable(self)

    def note_ready(self, parts: Sequence[Part]) -> None:
        """Learn for which parts something came."""
        self._ready = parts

    def run(self) -> None:
        """Take what came, and call back."""
        self._call(self.take_data())

    # --- the interface of rclpy's waitables -----------------------------------------------------

    def __enter__(self) -> None:
        for part in self.parts:
            part.handle.__enter__()

    def __exit__(self, *error: Any) -> None:
        for part in self.parts:
            part.handle.__exit__(*error)

    def get_num_entities(self) -> NumberOfEntities:
        """Return how much room it needs in a wait set."""
        return NumberOfEntities(num_clients=len(self.parts))

    def add_to_wait_set(self, wait_set: Any) -> None:
        """Add the parts."""
        self._places = [(part, wait_set.add_client(part.handle)) for part in self.parts]

    def is_ready(self, wait_set: Any) -> bool:
        """Tell whether something came."""
        self.note_ready(
            [part for part, place in self._places if wait_set.is_ready('client', place)]
        )
        return bool(self._ready)

    def take_data(self) -> Sequence[Call]:
        """Take all that came."""
        return [call for part in self._ready for call in part.take()]

    async def execute(self, taken_data: Any) -> None:
        """Call back."""
        self._call(taken_data)

    def _call(self, calls: Sequence[Call]) -> None:
        for call, message in calls:
            try:
                call(message)
            except Exception:  # noqa: BLE001 - whatever it is, the others go on
                report(self._logger)


def lean_clients(
    node: Node, logger: Logger, services: Sequence[Service]
) -> tuple[Sequence[LeanQuestions], Callable[[], None]]:
    """Return a client for each service, and what ends them."""
    clients = [LeanQuestions(node, service) for service in services]
    return clients, partial(_end, node, PartedWaitable(node, logger, clients))


def _end(node: Node, waitable: PartedWaitable) -> None:
    node.remove_waitable(waitable)
    for part in waitable.parts:
        part.handle.destroy_when_not_in_use()


# Is rclpy's inside the one that is known?

LISTS = ('_Node__waitables', '_timers', '_subscriptions', '_guards', '_clients', '_services')
"""Where rclpy keeps the entities of a node: to gather them each time takes longer."""

_HANDLES = {
    'Client': ('destroy_when_not_in_use', 'send_request', 'service_server_is_available',
               'take_response'),
    'Node': ('get_count_services',),
    'EventHandle': ('destroy_when_not_in_use', 'take_event'),
    'rcl_subscription_event_type_t': ('RCL_SUBSCRIPTION_MATCHED',),
    'Subscription': ('destroy_when_not_in_use', 'get_publisher_count', 'take_message'),
    'WaitSet': ('add_client', 'add_guard_condition', 'add_service', 'add_subscription',
                'add_timer', 'clear_entities', 'get_ready_entities', 'wait'),
    'InvalidHandle': (),
}  # fmt: skip
"""The names of rclpy's part in C++ that are used."""

KNOWN: dict[str, tuple[str, ...]] = {
    'Executor.__init__': (
        '49419339',
        '39798287',
    ),
    'Executor.create_task': (
        '702881a4',
        'ff80c345',
    ),
    'Executor.get_nodes': ('53c241ec',),
    'Executor.shutdown': (
        '79463870',
        '4b0b5191',
    ),
    'Executor.wake': ('36f07006',),
    'Executor._make_handler': (
        '13588f68',
        '5ef8c15a',
    ),
    'Executor._take_client': (
        '125b9e1a',
        '24e02afe',
    ),
    'Executor._take_guard_condition': (
        '40b0f709',
        '7ed412c9',
    ),
    'Executor._take_service': (
        '0628b711',
        'f006df70',
    ),
    'Executor._take_subscription': (
        '136c9235',
        '6f788ac8',
    ),
    'Executor._take_timer': (
        '32999b14',
        'e930778d',
    ),
    'Executor._take_waitable': (
        '2496804c',
        '25e84f04',
    ),
    'Executor.wait_for_ready_callbacks': (
        '4997ee95',
        'bd2ecc90',
    ),
    'Executor._wait_for_ready_callbacks': (
        '4709a882',
        'c96f3885',
    ),
    'SingleThreadedExecutor': (
        '543e3ccb',
        '01c66b0e',
    ),
    'GuardCondition': (
        'c4848f11',
        '4324a746',
    ),
    'NumberOfEntities': (
        'd2c7edcb',
        'd4c0842d',
    ),
    'Waitable': (
        'e8eebd4d',
        '8720adb6',
    ),
}
"""The first digits of the SHA-256 of each source that the lean way changes or stands on: in Jazzy,
and in Kilted."""


def sources() -> dict[str, Any]:
    """Return by name what `KNOWN` is about."""
    changed = (
        '__init__', 'create_task', 'get_nodes', 'shutdown', 'wake', '_make_handler',
        '_take_client', '_take_guard_condition', '_take_service', '_take_subscription',
        '_take_timer', '_take_waitable', 'wait_for_ready_callbacks', '_wait_for_ready_callbacks',
    )  # fmt: skip
    return {
        **{f'Executor.{name}': getattr(Executor, name, None) for name in changed},
        **{
            kind.__name__: kind
            for kind in (SingleThreadedExecutor, GuardCondition, NumberOfEntities, Waitable)
        },
    }


def digest(source: object) -> str:
    """Return what tells one source from another, however it is indented."""
    text = ''.join(inspect.getsource(source).split())  # type: ignore[arg-type]
    return hashlib.sha256(text.encode()).hexdigest()[:8]


def strange(node: Node) -> str:
    """Return what in rclpy is not as it is known; empty: all is.

    :raises Exception: something is so strange that it cannot be told
    """
    for name in LISTS:
        if not isinstance(vars(node).get(name), list):
            return f'Node.{name}'
    for kind, names in _HANDLES.items():
        for name in ('__init__', *names):
            if not hasattr(getattr(_rclpy, kind), name):
                return f'{kind}.{name}'
    for name, source in sources().items():
        if source is None or digest(source) not in KNOWN[name]:
            return name
    return ''
