"""Services that say their answer later, and again to a client that could not hear it yet.

A service is two DDS topics, discovered one by one. The request of a fresh client can come before
the way back to it is known; the middleware then waits for 100 ms and drops the answer, and rclpy
warns. The client would wait for ever.

A client that never hears, because it is discovered in part only or wants a quality of service that
does not fit, would keep the thread for as long with each of its answers, and the middleware does
not say whose the next one is. So a service has an allowance for such tries. When it is used up,
answers of this service wait; the line and all other services do not.

What takes long is not waited for: a callback returns a `Reply`, and the answer is sent
when it is there.
"""

from __future__ import annotations

import time
import warnings
from collections import deque
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, Protocol

from bt_orchestrator.model.allowance import Allowance
from bt_orchestrator.model.limits import UNHEARD_S
from bt_orchestrator.replies import Reply
from bt_orchestrator.ros.qos import SERVICES
from bt_orchestrator.ros.spare_log import SpareLog

if TYPE_CHECKING:
    from rclpy.node import Node

AGAIN_AFTER_S = (0.3, 1.0, 3.0)
"""Discovery takes up to 3 s; each attempt may take 100 ms of the thread."""

KEPT_FOR_NEW = UNHEARD_S.at_once / 2
"""Share of the allowance that is not used to send an answer again."""

HELD_S = 0.1
"""Wait before sending the answers that the allowance did not cover."""

MOST_HELD = 100
"""Answers of one service that wait; the oldest are dropped."""

UNHEARD = 'failed to send response (timeout)'
"""What the warning says."""


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
    service: Any = node.create_service(kind, name, callback, qos_profile=SERVICES)
    log = SpareLog(node.get_logger())
    later = partial(_once, node)
    answers = PatientAnswers(service.service_name, service.send_response, later, log)
    service.send_response = answers.send  # what every executor calls


class PatientAnswers:
    """Sends answers, some of them more than once."""

    def __init__(
        self,
        name: str,
        send: Callable[[Any, Any], object],
        later: Callable[[float, Callable[[], None]], None],
        logger: Logger,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Prepare.

        :param send: warns if the client cannot hear it, after having waited for it
        :param later: calls back once, after so many seconds
        """
        self._name = name
        self._send = send
        self._later = later
        self._logger = logger
        self._clock = clock
        self._allowance = Allowance(UNHEARD_S)
        self._waiting: deque[tuple[Any, Any]] = deque()
        self._holds = False

    def send(self, response: Any, header: Any) -> None:
        """Send an answer: now, or when it is there, and again if need be."""
        if isinstance(response, Reply):
            response.then(lambda there: self._send_in_turn(there, header))
        else:
            self._send_in_turn(response, header)

    def _send_in_turn(self, response: Any, header: Any) -> None:
        self._waiting.append((response, header))
        if len(self._waiting) > MOST_HELD:
            self._waiting.popleft()
            self._warn('was dropped: too many wait, since clients do not hear theirs')
        if not self._holds:
            self._send_waiting()

    def _send_waiting(self) -> None:
        self._holds = False
        try:
            while self._waiting and self._left > 0:
                self._attempt(*self._waiting.popleft(), 0)
        finally:
            if self._waiting:
                self._holds = True
                self._later(HELD_S, self._send_waiting)

    @property
    def _left(self) -> float:
        return self._allowance.left(self._clock())

    def _attempt(self, response: Any, header: Any, number: int) -> None:
        may_try = number == 0 or self._left > KEPT_FOR_NEW
        if may_try and self._is_heard(response, header):
            return
        if number < len(AGAIN_AFTER_S):
            again = partial(self._attempt, response, header, number + 1)
            self._later(AGAIN_AFTER_S[number], again)
            return
        self._warn('was not heard: its client is gone, not discovered, or wants another QoS')

    def _warn(self, what: str) -> None:
        text = f'an answer of {self._name} {what}'
        self._logger.warning(text)

    def _is_heard(self, response: Any, header: Any) -> bool:
        began = self._clock()
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter('always')
            self._send(response, header)
        now = self._clock()
        unheard = [one for one in said if UNHEARD in str(one.message)]
        for one in said:
            if one not in unheard:
                warnings.warn_explicit(one.message, one.category, one.filename, one.lineno)
        if unheard:
            self._allowance.use(now - began, now)
        return not unheard


def _once(node: Node, delay_s: float, callback: Callable[[], None]) -> None:
    def call() -> None:
        node.destroy_timer(timer)
        callback()

    from bt_orchestrator.ros.executor.timers import steady_timer  # the rest needs no ROS 2

    timer = steady_timer(node, delay_s, call)
