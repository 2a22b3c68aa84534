"""A port for a server that is started later, perhaps several times."""

from __future__ import annotations

from bt_orchestrator.ports.doors.listening import LOOPBACK, bound


class HeldPort:
    """Nobody else gets it until `close`: not as a port of its own, nor to connect from.

    It is bound and not listened at. So whoever asks for any free port gets another one, and a
    server that asks for this one may have it (SO_REUSEADDR, which every server here sets).
    """

    def __init__(self) -> None:
        """Take a free one."""
        self._socket = bound(LOOPBACK, 0, lambda _: None, listens=False)
        self.number: int = self._socket.getsockname()[1]

    def close(self) -> None:
        """Leave it to others."""
        self._socket.close()
