"""Gives each pytest process a ROS 2 domain of its own, so that runs side by side do not meet."""

from __future__ import annotations

import fcntl
import os
import tempfile
from pathlib import Path
from typing import TextIO

import pytest

DOMAINS = range(1, 102)
"""Free of clashes with the ephemeral ports of Linux, and without 0, where people work."""


def pytest_configure(config: pytest.Config) -> None:
    """Choose the domain before any test module can start a node or a subprocess."""
    domain, lock = take_free_domain()
    config.add_cleanup(lock.close)
    os.environ['ROS_DOMAIN_ID'] = str(domain)
    # Whatever the user's shell says, tests do not talk to other computers.
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'


def pytest_report_header() -> str:
    """Say which domain it is, for those who want to look into a running test."""
    return f'ROS_DOMAIN_ID: {os.environ["ROS_DOMAIN_ID"]}'


def take_free_domain() -> tuple[int, TextIO]:
    """Lock the first free domain, for as long as the lock is open.

    The search starts at a place of this process's own: a run that was killed may have left nodes
    in its domain, and the next run had better not follow it there.
    """
    start = os.getpid() % len(DOMAINS)
    for domain in (*DOMAINS[start:], *DOMAINS[:start]):
        lock = _lock(domain)
        if lock is not None:
            return domain, lock
    raise pytest.UsageError(f'all ROS domains from {DOMAINS[0]} to {DOMAINS[-1]} are in use')


def _lock(domain: int) -> TextIO | None:
    path = Path(tempfile.gettempdir(), f'bt_orchestrator_ros_domain_{domain}.lock')
    try:
        file = path.open('w')
    except PermissionError:  # another user's
        return None
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:  # held by another run
        file.close()
        return None
    return file
