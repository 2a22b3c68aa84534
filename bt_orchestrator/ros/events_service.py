"""`~/get_events`: what a client of the events topic has missed."""

from __future__ import annotations

from typing import Any

from bt_orchestrator_interfaces.srv import GetEvents
from rclpy.node import Node

from bt_orchestrator.errors import OrchestratorError
from bt_orchestrator.model.state import CellState
from bt_orchestrator.ports import EventStore
from bt_orchestrator.ros.event_message import event_message

MOST = 200
"""Most events of one answer: reading them keeps the tick thread for a few milliseconds."""


class EventsService:
    """Answers from the journal, between settles; so whatever it tells is durable."""

    def __init__(self, node: Node, state: CellState, store: EventStore) -> None:
        self._state = state
        self._store = store
        node.create_service(GetEvents, '~/get_events', self._answer)

    def _answer(self, request: Any, response: Any) -> Any:
        most = min(request.most or MOST, MOST)
        try:
            response.first_seq = self._store.first_seq()
            # What was removed cannot be told; a client sees that from first_seq.
            found = self._store.read(request.after_seq, most)
            response.events = [event_message(event, self._store.history) for event in found]
        except (OrchestratorError, OverflowError) as error:
            response.message = str(error)
            return response
        response.history = self._store.history
        response.last_seq = self._state.seq
        response.accepted = True
        return response
