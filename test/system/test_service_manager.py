"""A tree node under a service manager: it says when it is ready, that it lives, and its end."""

from __future__ import annotations

import signal
import socket
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import pytest
from cell_processes import StartCell
from patience import PATIENCE_S


@pytest.fixture
def manager(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[socket.socket]:
    monkeypatch.setenv('NOTIFY_SOCKET', str(tmp_path / 'notify'))
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listening:
        listening.bind(str(tmp_path / 'notify'))
        listening.settimeout(PATIENCE_S)
        yield listening


def heard(manager: socket.socket) -> list[str]:
    return manager.recv(4096).decode().split('\n')


def is_silent(manager: socket.socket, seconds: float) -> bool:
    """Tell whether nothing comes for a while, once what was sent is read."""
    manager.settimeout(seconds)
    with suppress(TimeoutError):
        for _ in range(3):
            heard(manager)
        return False
    return True


def test_a_node_is_ready_lives_and_stops(manager: socket.socket, start_cell: StartCell) -> None:
    cell = start_cell()
    ready, status = heard(manager)
    assert (ready, status[:23]) == ('READY=1', 'STATUS=tree node ready:')
    assert cell.node.output.startswith('tree node ready:')
    assert heard(manager) == ['WATCHDOG=1']

    cell.node.send(signal.SIGSTOP)
    assert is_silent(manager, 3.0)
    cell.node.send(signal.SIGCONT)
    manager.settimeout(PATIENCE_S)
    assert heard(manager) == ['WATCHDOG=1']

    cell.node.send(signal.SIGTERM)
    while heard(manager) != ['STOPPING=1']:
        pass
    assert cell.node.wait() == 0
