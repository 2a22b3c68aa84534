"""Which instance of a server it is."""

from __future__ import annotations

import time

from bt_orchestrator.ros.actions.renewable_client import RenewableClient

_LOOK_S = 1.0
"""Shortest time between two looks; each takes a while."""


class SeenServer:
    """The id of the server's status publisher, as it was seen last."""

    def __init__(self, clients: RenewableClient) -> None:
        self._clients = clients
        self._id: str | None = None
        self._seen_s = 0.0

    @property
    def id(self) -> str | None:
        """The id; None: no server was there, or more than one."""
        if self._id is None:
            self._id = self._clients.current.status.publisher_id()
        return self._id

    def look(self) -> None:
        """Look again, unless that was done a moment ago."""
        now = time.monotonic()
        if self._id is None or now - self._seen_s >= _LOOK_S:
            self._id, self._seen_s = self._clients.current.status.publisher_id(), now
