"""An event as a message (bt_orchestrator_interfaces/msg/Event)."""

from __future__ import annotations

from bt_orchestrator_interfaces.msg import Event as EventMessage

from bt_orchestrator.model.codec import to_text
from bt_orchestrator.model.events import Event
from bt_orchestrator.ros.stamps import to_time


def event_message(event: Event, history: str) -> EventMessage:
    """Build the message of a durable event.

    :param history: name of its journal
    """
    return EventMessage(
        seq=event.seq,
        history=history,
        stamp=to_time(event.time),
        event=event.event,
        record=to_text(event),
    )
