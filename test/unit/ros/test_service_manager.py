"""What a service manager hears, on a real socket."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from bt_orchestrator.ros.service_manager import ALIVE, READY, is_told, tell


@pytest.fixture(params=['{folder}/notify', '@{folder}/abstract'])
def manager(
    request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[socket.socket]:
    """A manager that listens at a path, or at an abstract name."""
    address = request.param.format(folder=tmp_path)
    monkeypatch.setenv('NOTIFY_SOCKET', address)
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listening:
        listening.bind(address.replace('@', '\0', 1))
        listening.settimeout(10)
        yield listening


def test_a_manager_hears_each_message_whole(manager: socket.socket) -> None:
    assert is_told()
    tell(READY, 'STATUS=it works')
    tell(ALIVE)
    assert manager.recv(1000) == b'READY=1\nSTATUS=it works'
    assert manager.recv(1000) == b'WATCHDOG=1'


def test_a_manager_that_reads_nothing_holds_up_nobody(manager: socket.socket) -> None:
    for _ in range(10_000):
        tell(ALIVE)
    assert manager.recv(1000) == b'WATCHDOG=1'


def test_without_a_manager_nothing_happens(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv('NOTIFY_SOCKET', raising=False)
    assert not is_told()
    tell(READY)
    monkeypatch.setenv('NOTIFY_SOCKET', str(tmp_path / 'gone'))
    tell(READY)
