"""Services that answer every request, later if need be, and again to who could not hear it.

A service is two DDS topics, discovered one by one. The request of a fresh client can come before
the way back to it is known; the middleware then drops the answer, and rclpy warns. The client
would wait for ever. So such an answer is sent again, some times.

It may also be the request of a client that has left: what it asked before waits in the queue of
the service. By default the middleware waits for 100 ms before it drops an answer, so that a client
that asks a lot and leaves, or one that wants a quality of service that does not fit, would keep
the thread for many seconds. `prompt_profile.py` has it drop answers at once. It is not obeyed by
every middleware, and none says whose the next answer is; so after each such try everything else
has its turn, for a while if it took long (`Turns`), and there are two allowances for tries: of
each service, and of all that have made some lately. When one is used up, answers of these services
wait; the line and all other services do not.

What takes long is not waited for: a callback returns a `Reply`, and the answer is sent
when it is there.
"""

from __future__ import annotations

import math
import time
import warnings
from collections import deque
from collections.abc import Callable, MutableMapping
from functools import partial
from typing import Any, Protocol
from weakref import WeakKeyDictionary

from rclpy.node import Node

from bt_orchestrator.base.replies import Reply, Steps, begin
from bt_orchestrator.model.limits import MESSAGE, UNHEARD_S, UNHEARD_TOGETHER_S, Allowance, cut
from bt_orchestrator.ports.spare_log import SpareLog
from bt_orchestrator.ros.qos import SERVICES

AGAIN_AFTER_S = (0.1, 0.3, 1.0, 3.0)
"""Discovery takes up to 3 s, and mostly some milliseconds."""

KEPT_FOR_NEW = UNHEARD_S.at_once / 2
"""Share of the allowance that is not used to send an answer again."""

HELD_S = 0.1
"""Wait before sending the answers that the allowance did not cover."""

SUSPECT_S = 30.0
"""How long after an answer that was not heard a service shares the common allowance."""

_turns: MutableMapping[Node, Turns] = WeakKeyDictionary()
"""Of each node, whose services share one thread."""

MOST_HELD = 100
"""Answers of one service that wait; the oldest are dropped."""

UNHEARD = 'failed to send response (timeout)'
"""The text of the warning."""


class Logger(Protocol):
    """The part of a ROS 2 logger that is needed here."""

    def warning(self, message: str) -> object:
        """Report something odd."""


def create_patient_service(
    node: Node, kind: Any, name: str, callback: Callable[[Any, Any], Any]
) -> None:
    """Create a service whose answers are sent again if its client cannot hear them yet.

    :param callback: returns the response, or a `Reply` that is to be it
    """
    _be_patient(node, node.create_service(kind, name, callback, qos_profile=SERVICES))


def make_all_patient(node: Node) -> None:
    """Do the same for the services that a node has: those for its parameters."""
    for service in node.services:
        _be_patient(node, service)


def _be_patient(node: Node, service: Any) -> None:
    turns = _turns.get(node) or _turns.setdefault(node, Turns(_later_on(node)))
    log = SpareLog(node.get_logger())
    answers = PatientAnswers(service.service_name, service.send_response, turns, log)
    service.send_response = answers.send  # what every executor calls


class PatientAnswers:
    """Sends answers, some of them more than once."""

    def __init__(
        self,
        name: str,
        send: Callable[[Any, Any], object],
        turns: Turns,
        logger: Logger,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Prepare.

        :param send: warns if the client cannot hear it, after having waited for it
        :param turns: those of all services of the node
        """
        self._name = name
        self._send = send
        self._turns = turns
        self._logger = logger
        self._clock = clock
        self._allowance = Allowance(UNHEARD_S)
        self._waiting: deque[tuple[Any, Any, int]] = deque()
        """Answers with their headers, and how often each was tried: never."""
        self._again: deque[tuple[Any, Any, int]] = deque()
        """The same of those to be sent again; few, since the allowances limit the tries."""
        self._holds = False
        """Whether there will be a call that sends what waits."""
        self._unheard_at = -math.inf

    def send(self, response: Any, header: Any) -> None:
        """Send an answer: now, or when it is there, and again if need be."""
        if isinstance(response, Reply):
            response.then(lambda there: self._send_in_turn(there, header))
        else:
            self._send_in_turn(response, header)

    def _send_in_turn(self, response: Any, header: Any) -> None:
        self._waiting.append((response, header, 0))
        if len(self._waiting) > MOST_HELD:
            self._waiting.popleft()
            self._warn('was dropped: too many wait, since clients do not hear theirs')
        if not self._holds:
            self._send_waiting()

    def _send_waiting(self) -> None:
        """Send what waits, up to the first that is not heard: then others have their turn."""
        self._holds, heard = False, True
        try:
            while heard and self._is_owing and not self._turns.pauses and self._left > 0:
                heard = self._attempt(*(self._again or self._waiting).popleft())
        finally:
            if self._is_owing or not heard:
                self._hold()

    def _hold(self) -> None:
        """Send nothing before the next turn."""
        self._holds = True
        if self._turns.pauses:
            self._turns.wait(self._send_waiting)
        else:
            self._turns.later(0.0 if self._left > 0 else HELD_S, self._send_waiting)

    @property
    def _is_owing(self) -> bool:
        return bool(self._again or self._waiting)

    @property
    def _left(self) -> float:
        now = self._clock()
        own = self._allowance.left(now)
        is_suspect = now - self._unheard_at < SUSPECT_S
        return min(own, self._turns.left(now)) if is_suspect else own

    def _attempt(self, response: Any, header: Any, tried: int) -> bool:
        heard = self._is_heard(response, header)
        if not heard:
            self._send_later(response, header, tried + 1)
        return heard

    def _send_later(self, response: Any, header: Any, tried: int) -> None:
        if tried <= len(AGAIN_AFTER_S):
            again = partial(self._send_again, response, header, tried)
            self._turns.later(AGAIN_AFTER_S[tried - 1], again)
        else:
            self._warn('was not heard: its client is gone, not discovered, or wants another QoS')

    def _send_again(self, response: Any, header: Any, tried: int) -> None:
        if self._left <= KEPT_FOR_NEW:
            self._send_later(response, header, tried + 1)
            return
        self._again.append((response, header, tried))
        if not self._holds:
            self._send_waiting()

    def _warn(self, what: str) -> None:
        text = f'an answer of {self._name} {what}'
        self._logger.warning(text)

    def _is_heard(self, response: Any, header: Any) -> bool:
        began = self._clock()
        with warnings.catch_warnings(record=True) as records:
            warnings.simplefilter('always')
            self._send(response, header)
        now = self._clock()
        unheard = [record for record in records if UNHEARD in str(record.message)]
        for record in records:
            if record not in unheard:
                warnings.warn_explicit(
                    record.message, record.category, record.filename, record.lineno
                )
        if unheard:
            self._unheard_at = now
            self._allowance.use(now - began, now)
            self._turns.use(now - began, now)
        return not unheard


def _later_on(node: Node) -> Later:
    from bt_orchestrator.ros.executor.alarms import Alarms  # the rest needs no ROS 2

    made: list[Alarms] = []

    def later(seconds: float, callback: Callable[[], None]) -> None:
        if not made:  # most nodes never need the timer
            made.append(Alarms(node))
        made[0].call_after(seconds, callback)

    return later


# The pace of answers without a reader, for all services of a node together.

LONG_S = 0.05
"""A try that took longer has kept the thread from others; the next one lets them go first."""

PAUSE = 0.5
"""Pause after a long try, as a share of the time that it took: whatever else is ready has its
turn."""

Later = Callable[[float, Callable[[], None]], object]


class Turns:
    """Pauses after each long try that was not heard; then one service after the other goes on.

    Such a try may block the tick thread for 0.1 s, and many of them may be due at a time.
    """

    def __init__(self, later: Later) -> None:
        """Begin without a pause.

        :param later: calls back once, after so many seconds
        """
        self.later = later
        self._waiting: deque[Callable[[], None]] = deque()
        self._allowance = Allowance(UNHEARD_TOGETHER_S)
        self.pauses = False
        """Whether nothing is to be sent now."""

    def left(self, now: float) -> float:
        """Return how many seconds may be spent now; below 0: overdrawn."""
        return self._allowance.left(now)

    def use(self, seconds: float, now: float) -> None:
        """Note an answer that was not heard, and pause if it took long."""
        self._allowance.use(seconds, now)
        if seconds > LONG_S and not self.pauses:
            self.pauses = True
            self.later(PAUSE * seconds, self._go_on)

    def wait(self, go_on: Callable[[], None]) -> None:
        """Call back after the pause, after those that came before."""
        self._waiting.append(go_on)

    def _go_on(self) -> None:
        self.pauses = False
        while self._waiting and not self.pauses:
            self._waiting.popleft()()


# Services that answer every request, whatever is wrong with it.


def serve(node: Node, kind: Any, name: str, handle: Callable[[Any, Any], Steps[None]]) -> None:
    """Offer a private service of a node, which answers when it has been handled.

    :param handle: fills the response; an exception becomes a refusal, and stops nothing
    """
    spare_log = SpareLog(node.get_logger())

    async def answer(request: Any, response: Any) -> Any:
        try:
            await handle(request, response)
        except Exception as error:  # noqa: BLE001 - a bad request never stops the node
            spare_log.error(f'{name} failed: {error!r}')
            response.accepted = False
            response.message = cut(f'internal error, see the log of the node: {error!r}', MESSAGE)
        return response

    create_patient_service(node, kind, f'~/{name}', lambda *asked: begin(answer(*asked)))
