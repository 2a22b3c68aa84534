"""Fetching events from the node's journal in the background."""

from __future__ import annotations

import time
from typing import Any, NamedTuple

from bt_orchestrator_interfaces.srv import GetEvents

from bt_orchestrator.ros.link.client import NodeClient

GIVEN_UP_S = 5.0
"""After so long without an answer the request or the answer is lost."""


class _Fetch(NamedTuple):
    future: Any
    """None: there was no service to ask."""
    until: float


class EventFetches:
    """Requests to `~/get_events` that are under way, at most one for each reader."""

    def __init__(self, client: NodeClient) -> None:
        """Prepare; the node knows of it once it knows what `client` makes after it."""
        self._client = client
        self._service = client.service(GetEvents, 'get_events')
        self._pending: dict[object, _Fetch] = {}

    def begin(self, reader: object, after_seq: int) -> None:
        """Ask for the events after one."""
        future = None
        if self._service.service_is_ready():
            future = self._service.call_async(GetEvents.Request(after_seq=after_seq))
        self._pending[reader] = _Fetch(future, time.monotonic() + GIVEN_UP_S)

    @property
    def has_any(self) -> bool:
        """Tell whether an answer is there."""
        return any(one.future is not None and one.future.done() for one in self._pending.values())

    def take(self, reader: object) -> Any:
        """Return the answer that is there for a reader; None: there is none."""
        fetch = self._pending.get(reader)
        if fetch is None or fetch.future is None or not fetch.future.done():
            return None
        del self._pending[reader]
        return fetch.future.result()

    def is_given_up(self, reader: object) -> bool:
        """Tell, once, that no answer will come."""
        fetch = self._pending.get(reader)
        if fetch is None or (fetch.future is not None and time.monotonic() < fetch.until):
            return False
        if fetch.future is not None:
            self._service.remove_pending_request(fetch.future)
        del self._pending[reader]
        return True
