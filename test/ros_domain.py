"""Gives each test a ROS 2 domain of its own, so that tests do not meet, nor what others left."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Iterator, MutableMapping
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO

import pytest
from meeting_place import LOCKS

from bt_orchestrator.base.diagnosis.ros_environment import domains_in_use

DOMAINS = range(1, 102)
"""Free of clashes with the ephemeral ports of Linux, and without 0, where people work."""

APART = 37
"""Workers, whose process ids are neighbours, begin far from each other."""

SOCKETS = Path('/proc/net/udp')
"""Where the kernel lists the ports that are in use on this computer."""

PROFILES = ('FASTDDS_DEFAULT_PROFILES_FILE', 'FASTRTPS_DEFAULT_PROFILES_FILE')
"""The second is Jazzy's name, of which Kilted warns."""


def discover_fast(environment: MutableMapping[str, str] = os.environ) -> None:
    """Let processes find each other in tenths of a second instead of up to three seconds."""
    is_jazzy = os.environ.get('ROS_DISTRO') == 'jazzy'
    name = 'fast_discovery_2.xml' if is_jazzy else 'fast_discovery.xml'
    environment[PROFILES[is_jazzy]] = str(Path(__file__).parent / 'data' / name)


@contextmanager
def discovering_fast() -> Iterator[None]:
    """Do the same for a while."""
    changed: dict[str, str] = {}
    discover_fast(changed)
    with pytest.MonkeyPatch.context() as patch:
        for name, value in changed.items():
            patch.setenv(name, value)
        yield


class OwnDomain:
    """The domain of this process and of those it starts; locked against other test processes.

    A context, which takes a domain and leaves it. It takes none in which somebody is who knows of
    no lock, such as a person's demo: a cell with two servers of an action waits for one to leave.
    """

    def __init__(self) -> None:
        self._place = os.getpid() * APART % len(DOMAINS)
        self._lock: TextIO | None = None
        self._kept: list[TextIO] = []

    def __enter__(self) -> OwnDomain:
        # Whatever the user's shell says, tests do not talk to other computers.
        os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
        self.move()
        return self

    def __exit__(self, *exception: object) -> None:
        if self._lock is not None:
            self._lock.close()

    def move(self) -> None:
        """Go to the next free domain: a killed process is seen in its own for 20 s more.

        :raises pytest.UsageError: none is free
        """
        inhabited = domains_in_use(SOCKETS.read_text(encoding='ascii'))
        for step in range(1, len(DOMAINS) + 1):
            place = (self._place + step) % len(DOMAINS)
            lock = None if DOMAINS[place] in inhabited else _lock(DOMAINS[place])
            if lock is not None:
                if self._lock not in self._kept:
                    self.__exit__()
                self._place, self._lock = place, lock
                os.environ['ROS_DOMAIN_ID'] = str(DOMAINS[place])
                return
        raise pytest.UsageError(f'all ROS domains from {DOMAINS[0]} to {DOMAINS[-1]} are in use')

    @contextmanager
    def keep(self) -> Iterator[None]:
        """Let nobody else into the present domain, wherever the tests go meanwhile."""
        lock = self._lock
        assert lock is not None
        self._kept.append(lock)
        try:
            yield
        finally:
            self._kept.remove(lock)
            if lock is not self._lock:
                lock.close()


_own = OwnDomain()

kept_domain = _own.keep
"""For a fixture that lives longer than one test."""


def pytest_configure(config: pytest.Config) -> None:
    """Choose a domain before any test module can start a node or a subprocess."""
    _own.__enter__()
    config.add_cleanup(_own.__exit__)


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Choose another one for each test, and tell who reads about a failure which it was."""
    _own.move()
    item.add_report_section('setup', 'ROS_DOMAIN_ID', os.environ['ROS_DOMAIN_ID'])


def _lock(domain: int) -> TextIO | None:
    path = LOCKS / f'bt_orchestrator_ros_domain_{domain}.lock'
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
