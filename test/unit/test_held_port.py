"""A port of a test stays its own, before its server is there and while that is started again."""

from __future__ import annotations

import socket
from contextlib import closing

import pytest
from held_port import HeldPort

from bt_orchestrator.ports.doors.listening import LOOPBACK, bound


def test_a_held_port_is_its_servers_alone() -> None:
    with closing(HeldPort()) as held:
        for _ in range(2):
            with bound(LOOPBACK, held.number, lambda _: None):
                pass
            with socket.socket() as stranger, pytest.raises(OSError, match='in use'):
                stranger.bind((LOOPBACK, held.number))
