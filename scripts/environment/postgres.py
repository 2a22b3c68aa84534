"""A PostgreSQL server of the operating system, for tests that start their own."""

from __future__ import annotations

import shutil
from pathlib import Path

from report import Failure
from system import can_install, install

PACKAGES = ('postgresql',)
DEBIAN = Path('/usr/lib/postgresql')
SETTINGS = Path('/etc/postgresql-common/createcluster.conf')


def find_server() -> str:
    """Return the path of the newest server program; empty if there is none."""
    versions = sorted(DEBIAN.glob('*/bin/postgres'), key=lambda path: _number(path.parts[-3]))
    return str(versions[-1]) if versions else shutil.which('postgres') or ''


def _number(text: str) -> float:
    return float(text) if text.replace('.', '', 1).isdigit() else 0.0


def install_missing_server(log: Path) -> None:
    """Install a server where there is none and that is possible, else say what to do."""
    if find_server():
        return
    if not can_install():
        raise Failure(
            "tests of the plant's database need a PostgreSQL server; install it and run this "
            f'again:\n    sudo apt-get install -y {" ".join(PACKAGES)}'
        )
    if not SETTINGS.exists():  # else the package starts a server of its own
        SETTINGS.parent.mkdir(exist_ok=True)
        SETTINGS.write_text('create_main_cluster = false\n')
    install(log, *PACKAGES)
    if not find_server():
        raise Failure(f'apt-get succeeded, but there is no server in {DEBIAN}')
