"""Where the server listens and whom it lets in: options, and what they must be together."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.ports.doors.listening import LOOPBACK, is_loopback
from bt_orchestrator.script.users.file import KnownUsers, UsersUnusable


class AccessRefused(OrchestratorError):
    """The server does not start like this; the message says why, and what to do."""


@dataclass(frozen=True)
class Access:
    """The ways to the server."""

    users: Path
    """File of the users and their roles (`script/users/`)."""
    pki: Path
    """Folder of the certificates (`opcua.pki`)."""
    host: str = LOOPBACK
    port: int = 0
    """0: any free one."""
    is_insecure: bool = False
    """Unencrypted connections are accepted as well; passwords are encrypted all the same."""

    def check(self) -> None:
        """Refuse options that would let in every client, or no client.

        :raises AccessRefused: says what was expected
        """
        if self.is_insecure and not is_loopback(self.host):
            raise AccessRefused(
                f'--insecure lets clients connect without encryption, and --host {self.host} lets '
                'other computers reach the server; leave one of the two out'
            )
        try:
            has_users = bool(KnownUsers(self.users).all())
        except UsersUnusable as error:
            raise AccessRefused(str(error)) from error
        if not has_users:
            raise AccessRefused(
                f'there are no users in {self.users}; add one, who can log in, with: '
                'bt-orchestrator user add mes --role mes'
            )
