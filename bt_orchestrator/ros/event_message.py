"""An event as a message (bt_orchestrator_interfaces/msg/Event)."""

from __future__ import annotations

import json

from bt_orchestrator_interfaces.msg import Event as EventMessage

from bt_orchestrator.model.codec import to_record
from bt_orchestrator.model.events import Event
from bt_orchestrator.ros.stamps import to_time


def event_message(event: Event) -> EventMessage:
    """Build the message of a durable event."""
    return EventMessage(
        seq=event.seq,
        stamp=to_time(event.time),
        event=event.event,
        record=json.dumps(to_record(event), ensure_ascii=False),
    )
