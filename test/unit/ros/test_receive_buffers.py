"""A busy process loses no datagrams for want of room."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from bt_orchestrator.ros import memory


@pytest.fixture
def listening() -> Iterator[socket.socket]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
        receiver.bind(('127.0.0.1', 0))
        yield receiver


def test_burst_beyond_default_buffer_is_received(listening: socket.socket) -> None:
    largest = int(Path('/proc/sys/net/core/rmem_max').read_text())
    memory.widen_buffers()
    given = listening.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF)
    assert given >= min(memory.WANTED_BYTES, largest)
    sent = min(memory.WANTED_BYTES, largest) // 4 // 1000
    for number in range(sent):
        listening.sendto(number.to_bytes(4, 'big') * 250, listening.getsockname())
    listening.settimeout(5.0)
    assert [int.from_bytes(listening.recv(2000)[:4], 'big') for _ in range(sent)] == list(
        range(sent)
    )


def test_a_wider_buffer_stays(listening: socket.socket, monkeypatch: pytest.MonkeyPatch) -> None:
    before = listening.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF)
    monkeypatch.setattr(memory, 'WANTED_BYTES', before // 2)
    memory.widen_buffers()
    assert listening.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF) == before
