"""The event stream of a node without gaps, whatever was lost on the way."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator
from typing import Any, Protocol

from bt_orchestrator.model.status import CellStatus


class EventSource(Protocol):
    """A tree node, as `ros.client.NodeClient` shows it."""

    def on_event(self, callback: Callable[[Any], None]) -> None:
        """Call back with every event from now on."""

    def on_status(self, callback: Callable[[CellStatus], object]) -> None:
        """Call back with the newest status, the latched one first."""

    def status(self) -> CellStatus:
        """Return the latched status."""

    def events_after(self, seq: int) -> Any:
        """Return events from the journal of the node (srv/GetEvents)."""


class EventFollower:
    """Events in the order of their numbers: from the topic, and from the journal what it missed.

    A number that jumps, or a status that is further on, tells of a gap. Numbers count within one
    history: where another one is seen, the node has another journal, and everything begins anew.
    """

    def __init__(
        self,
        client: EventSource,
        after_seq: int | None,
        on_removed: Callable[[int, int], None] = lambda _, __: None,
        on_anew: Callable[[str], None] = lambda _: None,
    ) -> None:
        """Connect.

        :param after_seq: the last event that is known; None: only what happens from now on
        :param on_removed: called with the first and the last number of events that were removed
            from the journal and cannot be had any more
        :param on_anew: called with the name of another history, before its first event
        :raises NodeUnreachable: the node is not there
        """
        self._client = client
        self._on_removed = on_removed
        self._on_anew = on_anew
        self._inbox: deque[Any] = deque()
        self._told: CellStatus | None = None
        """The last status."""
        client.on_event(self._receive)
        client.on_status(self._note)
        begin = client.status()
        self._history = begin.history
        self._left: set[str] = set()
        """Histories of nodes that are gone; their last words may still come."""
        self._last = begin.seq if after_seq is None else after_seq

    def take(self) -> Iterator[Any]:
        """Yield the events (bt_orchestrator_interfaces/msg/Event) that are new.

        :raises NodeUnreachable: some were missed, and the node does not answer
        """
        while self._inbox:
            message = self._inbox.popleft()
            yield from self._fetch(message.history, message.seq - 1)
            if message.history == self._history and message.seq == self._last + 1:
                self._last = message.seq
                yield message
        if self._told is not None:
            yield from self._fetch(self._told.history, self._told.seq)

    def _receive(self, message: Any) -> None:
        self._inbox.append(message)

    def _note(self, status: CellStatus) -> None:
        self._told = status

    def _fetch(self, history: str, until: int) -> Iterator[Any]:
        """Yield from the journal what is new up to a number of a history."""
        while self._follows(history) and self._last < until:
            answer = self._client.events_after(self._last)
            if answer.history != history:
                return  # by another node already, which is heard of in its own words
            if answer.first_seq > self._last + 1:
                self._on_removed(self._last + 1, answer.first_seq - 1)
            if not answer.events:
                return
            for message in answer.events:
                self._last = message.seq
                yield message

    def _follows(self, history: str) -> bool:
        """Tell whether a history is the present one, which a new one becomes."""
        if history in self._left:
            return False
        if history != self._history:
            self._left.add(self._history)
            self._history, self._last = history, 0
            self._on_anew(history)
        return True
