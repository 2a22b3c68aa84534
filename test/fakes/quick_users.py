"""A file of users whose passwords cost nothing to check."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import yaml

from bt_orchestrator.model.by import Role
from bt_orchestrator.script.users.file import Content, User, _plain
from bt_orchestrator.script.users.panels import Panels
from bt_orchestrator.script.users.passwords import Cost, hashed

PASSWORD = 'long enough'
"""Of everybody."""

QUICK = Cost(n=2, r=1, p=1)

NO_PANELS = Panels()


def write_users(
    path: Path, roles: Mapping[str, Role], password: str = PASSWORD, *, panels: Panels = NO_PANELS
) -> Path:
    """Write users with these roles; returns the path."""
    users = {name: User(role, hashed(password, QUICK)) for name, role in roles.items()}
    fresh = path.with_suffix('.new')
    fresh.touch(0o600)
    fresh.write_text(yaml.safe_dump(_plain(Content(users, panels))))
    return fresh.replace(path)
