"""A service client that calls back in the turn in which an answer came."""

from __future__ import annotations

from collections.abc import Callable, Sequence, Sized
from typing import Any

from rclpy.node import Node

from bt_orchestrator.ros.executor.handles import Call, service_client

Answered = Callable[[Any], None]
"""Gets the response."""


class Question:
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


class Questions:
    """One service, and the questions that are open at it.

    rclpy's own client keeps a future for each, and lets the executor make a turn of its callback.
    """

    def __init__(
        self,
        node: Node,
        service_class: Any,
        name: str,
        is_last: Callable[[Any], bool] = lambda _: True,
    ) -> None:
        """Make the client; its name is remapped as any other.

        :param is_last: whether a response ends a question; of several servers with one name each
            gives its own, and the first one need not be that of the one that knows
        """
        self._response = service_class.Response
        self._is_last = is_last
        self._open: dict[int, Answered] = {}
        self.handle = service_client(node, service_class, name)

    def __len__(self) -> int:
        return len(self._open)

    @property
    def awaited(self) -> Sized:
        """Return the questions that are open. Other answers are dropped with the next."""
        return self._open

    def ask(self, request: Any, answered: Answered) -> Question:
        """Send a request.

        :param answered: called with each response up to the last one
        """
        sequence = self.tell(request)
        self._open[sequence] = answered
        return Question(self._open, sequence)

    def tell(self, request: Any) -> int:
        """Send a request whose answer does not matter; return its number."""
        with self.handle:
            return int(self.handle.send_request(request))

    def is_served(self) -> bool:
        """Tell whether the service is there; goes through the whole ROS graph twice."""
        with self.handle:
            return bool(self.handle.service_server_is_available())

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

    def _asked(self, sequence: int, response: Any) -> Answered | None:
        """Return what is to be called with a response; the last one closes the question."""
        if self._is_last(response):
            return self._open.pop(sequence, None)
        return self._open.get(sequence)
