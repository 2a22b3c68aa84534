"""What of addresses is this computer."""

from __future__ import annotations

import pytest

from bt_orchestrator.doors.addresses import is_loopback


@pytest.mark.parametrize(
    ('address', 'is_here'),
    [
        ('127.0.0.1', True),
        ('127.8.8.8', True),
        ('::1', True),
        ('::ffff:127.0.0.1', True),
        ('localhost', True),
        ('0.0.0.0', False),
        ('::', False),
        ('10.0.0.1', False),
        ('localhost.example.org', False),
        ('', False),
    ],
)
def test_this_computer(address: str, is_here: bool) -> None:
    assert is_loopback(address) is is_here
