"""The event stream of a node without gaps, whatever was lost on the way."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from typing import Any, Protocol

STARTED = 'orchestrator.started'


class EventSource(Protocol):
    """A tree node, as `ros.client.NodeClient` shows it."""

    def on_event(self, callback: Callable[[Any], None]) -> None:
        """Call back with every event from now on."""

    def on_status(self, callback: Callable[[Any], None]) -> None:
        """Call back with every status, the latched one first."""

    def status(self) -> Any:
        """Return the latched status."""

    def events_after(self, seq: int) -> Any:
        """Return events from the journal of the node (srv/GetEvents)."""


class EventFollower:
    """Events in the order of their numbers: from the topic, and from the journal what it missed.

    A number that jumps, or a status that is further on, tells of a gap.
    """

    def __init__(
        self,
        client: EventSource,
        after_seq: int | None,
        on_removed: Callable[[int, int], None] = lambda _, __: None,
    ) -> None:
        """Connect.

        :param after_seq: the last event that is known; None: only what happens from now on
        :param on_removed: called with the first and the last number of events that were removed
            from the journal and cannot be had any more
        :raises NodeUnreachable: the node is not there
        """
        self._client = client
        self._on_removed = on_removed
        self._inbox: deque[Any] = deque()
        self._newest = 0
        """The last event that the node is known to have."""
        client.on_event(self._receive)
        client.on_status(self._note)
        self._last = client.status().seq if after_seq is None else after_seq

    def take(self) -> Iterator[Any]:
        """Yield the events (bt_orchestrator_interfaces/msg/Event) that are new.

        :raises NodeUnreachable: some were missed, and the node does not answer
        """
        while self._inbox:
            message = self._inbox.popleft()
            if message.seq <= self._last and message.event == STARTED:
                self._last = message.seq - 1  # it forgot everything, and counts from 1 again
            yield from self._fetch(message.seq - 1)
            if message.seq == self._last + 1:
                self._last = message.seq
                yield message
        yield from self._fetch(self._newest)

    def _receive(self, message: Any) -> None:
        self._inbox.append(message)

    def _note(self, status: Any) -> None:
        self._newest = status.seq

    def _fetch(self, until: int) -> Iterator[Any]:
        """Yield from the journal what is new up to a number."""
        while self._last < until:
            answer = self._client.events_after(self._last)
            if answer.first_seq > self._last + 1:
                self._on_removed(self._last + 1, answer.first_seq - 1)
            if not answer.events:
                return
            for message in answer.events:
                self._last = message.seq
                yield message
