"""Where the server listens and whom it lets in: options, and what they must be together."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from bt_orchestrator.doors.listening import is_loopback
from bt_orchestrator.errors import OrchestratorError

LOOPBACK = '127.0.0.1'
PORT = 4840


class AccessRefused(OrchestratorError):
    """The server does not start like this; the message says why, and what to do."""


@dataclass(frozen=True)
class Access:
    """Who reaches the server, and how people are known there."""

    users: Path
    host: str = LOOPBACK
    port: int = PORT
    local_user: str = ''
    """Who calls without a login and without encryption, as an engineer: for trials on one
    computer. Empty: nobody does."""

    def check(self) -> None:
        """Refuse options that would let in anybody.

        :raises AccessRefused: says what was expected
        """
        if not self.local_user:
            raise AccessRefused(
                'clients without a login and encryption are let in with --insecure alone, and '
                'only on this computer'
            )
        if not is_loopback(self.host):
            raise AccessRefused(
                f'--insecure makes everybody who reaches the server an engineer, without '
                f'encryption, and --host {self.host} lets others reach it; leave one of the two '
                'out'
            )
