"""Stop signals as a request."""

from __future__ import annotations

import os
import signal
import threading

import pytest
from patience import PATIENCE_S

from bt_orchestrator.base.stop_signals import StopSignals


@pytest.mark.parametrize('number', [signal.SIGINT, signal.SIGTERM])
def test_stop_signal_sets_request_and_wakes_waiter(number: signal.Signals) -> None:
    woken = threading.Event()
    with StopSignals() as stop:
        stop.notify(woken.set)
        assert not stop.requested

        os.kill(os.getpid(), number)

        assert woken.wait(PATIENCE_S)
        assert stop.requested


def test_earlier_request_wakes_later_waiter() -> None:
    first, second = threading.Event(), threading.Event()
    with StopSignals() as stop:
        stop.notify(first.set)
        os.kill(os.getpid(), signal.SIGTERM)
        assert first.wait(PATIENCE_S)

        stop.notify(second.set)

    assert second.is_set()


def test_afterwards_signals_do_what_they_did_before() -> None:
    before = signal.getsignal(signal.SIGTERM), signal.getsignal(signal.SIGINT)
    threads = threading.active_count()
    with StopSignals():
        assert signal.getsignal(signal.SIGTERM) != before[0]

    assert (signal.getsignal(signal.SIGTERM), signal.getsignal(signal.SIGINT)) == before
    assert threading.active_count() == threads
