"""`~/get_events`: what a client of the events topic has missed."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from bt_orchestrator_interfaces.srv import GetEvents
from rclpy.node import Node

from bt_orchestrator.base.errors import DamagedRecord, OrchestratorError
from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.model.limits import EVENTS_BYTES, EVENTS_PAGE, fitting
from bt_orchestrator.ports import EventStore
from bt_orchestrator.ros.services.event_message import event_message
from bt_orchestrator.ros.services.serving import serve


class EventsService:
    """Answers from the journal; so whatever it tells is durable."""

    def __init__(self, node: Node, orchestrator: Orchestrator, store: EventStore) -> None:
        self._orchestrator = orchestrator
        self._store = store
        self._log = node.get_logger()
        serve(node, GetEvents, 'get_events', self._answer)

    async def _answer(self, request: Any, response: Any) -> None:
        most = min(request.most or EVENTS_PAGE, EVENTS_PAGE)
        try:
            # What was removed or is damaged cannot be told; a client sees that from first_seq.
            response.first_seq, response.events = self._readable(request.after_seq, most)
        except (OrchestratorError, OverflowError) as error:
            response.message = str(error)
            return
        response.history = self._store.history
        response.last_seq = self._orchestrator.kept_seq
        response.accepted = True

    def _readable(self, after: int, most: int) -> tuple[int, list[Any]]:
        """Return the first event that can be had, and messages of events without gaps."""
        first = self._store.first_seq()
        while True:
            found: list[Any] = []
            try:
                found.extend(self._messages(after, most))
            except DamagedRecord as damage:
                self._log.warning(f'{damage}; clients that ask for it get the events after it')
                if not found:
                    after, first = damage.last, damage.last + 1
                    continue
            return first, found

    def _messages(self, after: int, most: int) -> Iterator[Any]:
        """Yield as many events as one answer may tell."""
        events = self._store.read(after, most)
        messages = (event_message(event, self._store.history) for event in events)
        return fitting(messages, EVENTS_BYTES, lambda message: len(message.record))
