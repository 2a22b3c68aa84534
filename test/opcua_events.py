"""Events, as asyncua's own client gets them."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from typing import Any

from asyncua import ua
from opcua_reader import Reader
from patience import PATIENCE_S

KINDS = (
    ua.ObjectIds.BaseEventType,
    ua.ObjectIds.TransitionEventType,
    ua.ObjectIds.AlarmConditionType,
)


class Heard:
    """What one subscription was told."""

    def __init__(self) -> None:
        self.events: list[Any] = []
        self.values: list[Any] = []
        self.number = 0
        """Id of the subscription."""

    def event_notification(self, event: Any) -> None:
        """Take note; called by the client."""
        self.events.append(event)

    @classmethod
    async def of(cls, reader: Reader, path: str = '', own: str = '') -> Heard:
        """Listen at a node of the cell, or at the server.

        :param own: path of a type of the cell whose fields are wanted too
        """
        heard = cls()
        subscription = await reader.client.create_subscription(20, heard)
        heard.number = subscription.subscription_id
        source = reader.node(path) if path else reader.client.nodes.server
        kinds = [reader.client.get_node(kind) for kind in KINDS]
        if own:
            kinds.append(reader.node(own))
        await subscription.subscribe_events(source, evtypes=kinds)
        return heard

    @classmethod
    async def of_value(cls, reader: Reader, path: str) -> Heard:
        """Hear each value of a variable."""
        heard = cls()
        subscription = await reader.client.create_subscription(20, heard)
        await subscription.subscribe_data_change(reader.node(path))
        return heard

    def datachange_notification(self, node: object, value: Any, data: object) -> None:
        """Take note; called by the client."""
        self.values.append(value)

    async def wait(self, is_it: Callable[[Any], object]) -> Any:
        """Wait for an event; returns the first."""
        deadline = time.monotonic() + PATIENCE_S
        while True:
            for event in self.events:
                if is_it(event):
                    return event
            assert time.monotonic() < deadline, [event.Message.Text for event in self.events]
            await asyncio.sleep(0.02)

    async def refresh(self, reader: Reader) -> list[Any]:
        """Ask for all conditions anew; returns the events that came for it."""
        self.events.clear()
        await reader.client.get_node(ua.ObjectIds.ConditionType).call_method(
            reader.client.get_node(ua.ObjectIds.ConditionType_ConditionRefresh),
            ua.Variant(self.number, ua.VariantType.UInt32),
        )
        end = ua.NodeId(ua.ObjectIds.RefreshEndEventType)
        await self.wait(lambda event: event.EventType == end)
        return list(self.events)
