"""The one user of a demo's OPC UA server: it needs a login, and everybody may know this one."""

from __future__ import annotations

from pathlib import Path

from bt_orchestrator.model.roles import Role
from bt_orchestrator.script.users.file import UsersFile

NAME, PASSWORD = 'demo', 'only-for-demos'


def opcua_options(folder: Path) -> list[str]:
    """Write the user; returns the options with which the server lets clients in.

    :param folder: of the demo; the server's certificate is kept there as well
    """
    users = folder / 'users.yaml'
    users.unlink(missing_ok=True)
    UsersFile(users).add(NAME, Role.ENGINEER, PASSWORD)
    return ['--insecure', '--users', str(users), '--pki', str(folder / 'pki')]
