"""Lines for systemd."""

from __future__ import annotations

import pytest

from bt_orchestrator.ros.service_manager import watchdog


def test_takeover_may_take_longer_than_tick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv('WATCHDOG_USEC', '4000000')
    assert watchdog(patient=True) == 'WATCHDOG_USEC=300000000'
    assert watchdog(patient=False) == 'WATCHDOG_USEC=4000000'


def test_without_a_watchdog_there_is_no_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv('WATCHDOG_USEC', raising=False)
    assert watchdog(patient=True) == ''
