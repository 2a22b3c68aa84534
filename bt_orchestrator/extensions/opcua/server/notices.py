"""Events of OPC UA: built at the record that they tell of, and sent in its order.

asyncua hands an event only to monitors of the node that it names, so each one is sent once for
each node whose monitors should have it, the Server object last.
"""

from __future__ import annotations

import asyncio
import hashlib
import logging
from collections import deque
from collections.abc import Awaitable, Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime, timezone
from itertools import chain

import asyncua
from asyncua import ua
from asyncua.common.events import Event

log = logging.getLogger(__name__)

SERVER = ua.NodeId(ua.ObjectIds.Server)


@dataclass(frozen=True)
class Told:
    """The fields of every event."""

    type_id: ua.NodeId
    id: bytes
    """The same for the same event, also after a restart of the server."""
    source: ua.NodeId
    source_name: str
    time: float
    """When it happened, by the node's clock."""
    message: str
    severity: int = 100
    """From 1 to 1000."""
    fields: Mapping[str, ua.Variant] = field(default_factory=dict)
    """Others, by browse path, as in `AckedState/Id`."""


class _Sent(Event):
    """The fields from which asyncua selects."""

    def __init__(self, notice: Told) -> None:
        super().__init__(SERVER)
        kind = ua.VariantType
        self.add_property('EventId', notice.id, kind.ByteString)
        self.add_property('EventType', notice.type_id, kind.NodeId)
        self.add_property('SourceNode', notice.source, kind.NodeId)
        self.add_property('SourceName', notice.source_name, kind.String)
        time = datetime.fromtimestamp(notice.time, timezone.utc)
        self.add_property('Time', time, kind.DateTime)
        self.add_property('ReceiveTime', datetime.now(timezone.utc), kind.DateTime)
        self.add_property('Message', ua.LocalizedText(notice.message), kind.LocalizedText)
        self.add_property('Severity', notice.severity, kind.UInt16)
        for name, value in notice.fields.items():
            self.add_property(name, value.Value, value.VariantType)


class Notices:
    """Sends events, in their order. All calls come from the loop."""

    def __init__(self, server: asyncua.Server, cell: ua.NodeId) -> None:
        self._service = server.iserver.subscription_service
        self._cell = cell
        self._waiting: deque[Callable[[], Awaitable[None]]] = deque()
        self._task: asyncio.Task[None] | None = None

    def tell(self, notice: Told, *nodes: ua.NodeId) -> None:
        """Send an event to the monitors of some nodes, of the cell and of the server."""
        everywhere = tuple(dict.fromkeys((*nodes, self._cell, SERVER)))
        self._put(lambda: self._to_all(notice, everywhere))

    def tell_one(self, several: Sequence[Told], subscription: int, item: int | None) -> None:
        """Send events to the monitors of one subscription.

        :param item: id of the only monitored item that gets them; None: all get them
        """
        self._put(lambda: self._to_one(several, subscription, item))

    def monitors(self, subscription: int, session: str) -> Collection[int] | None:
        """Return the ids of the monitored items of a subscription.

        :param session: that it must be of (`callers.Caller`)
        :return: None: the session has no such subscription
        """
        entry = self._service.subscriptions.get(subscription)
        if entry is None or str(entry.session_id) != session:
            return None
        return list(entry.monitored_item_srv._monitored_items)  # noqa: SLF001 - no other way

    async def sent(self) -> None:
        """Wait until everything is sent."""
        if self._task is not None:
            await self._task

    def _put(self, send: Callable[[], Awaitable[None]]) -> None:
        self._waiting.append(send)
        if self._task is None or self._task.done():
            self._task = asyncio.ensure_future(self._send())

    async def _send(self) -> None:
        while self._waiting:
            send = self._waiting.popleft()
            try:
                await send()
            except Exception:
                log.exception('defect: an event could not be sent')

    async def _to_all(self, notice: Told, nodes: Sequence[ua.NodeId]) -> None:
        sent = _Sent(notice)
        for subscription in list(self._service.subscriptions.values()):
            for node in nodes:
                sent.emitting_node = node
                await subscription.monitored_item_srv.trigger_event(sent)

    async def _to_one(self, several: Sequence[Told], number: int, item: int | None) -> None:
        subscription = self._service.subscriptions.get(number)
        if subscription is None:  # deleted meanwhile
            return
        monitors = subscription.monitored_item_srv
        by_node = monitors._monitored_events.values()  # noqa: SLF001 - asyncua has no other way
        items = list(chain.from_iterable(by_node)) if item is None else [item]
        for notice in several:
            for monitor in items:
                await monitors._trigger_event(_Sent(notice), monitor)  # noqa: SLF001 - the same


def id_of(*facts: object) -> bytes:
    """Return an EventId that is the same for the same facts, in every process."""
    return hashlib.sha256('\0'.join(map(str, facts)).encode()).digest()[:16]
