"""The name of the user of this program."""

from __future__ import annotations

import getpass
import os


def user_name() -> str:
    """Return the login name of the user; in a container the user id may have none."""
    try:
        name = getpass.getuser()
    except (ImportError, KeyError, OSError):
        return f'user {os.getuid()}'
    return name.encode(errors='replace').decode()
