"""The instance of the server."""

from __future__ import annotations

from bt_orchestrator.ros.actions.renewable_client import RenewableClient


class SeenServer:
    """The id of the server's status publisher, as it was seen last."""

    def __init__(self, clients: RenewableClient) -> None:
        self._clients = clients
        self._id: str | None = None

    @property
    def id(self) -> str | None:
        """The id; None: no server was there, or more than one."""
        if self._id is None:
            self.look()
        return self._id

    def look(self) -> None:
        """Look again; to be called once a second, as each look takes a while."""
        self._id = self._clients.current.status.publisher_id()
