"""More test processes than cores: the further ones begin a test only where the machine has time.

Tests of real programs wait most of the time, so many of them share a core. How many do so without
missing what they wait for depends on the machine, and on what else it does.
"""

from __future__ import annotations

import fcntl
import os
import re
import time
from collections.abc import Generator
from pathlib import Path

import pytest
from meeting_place import LOCKS

AT_ONCE = 'TEST_PROCESSES_AT_ONCE'
"""Environment variable: how many processes never wait; without it none does."""

LOOK_S = 0.5
"""For so long the machine is looked at: a program that starts is seen within it."""

IDLE = 0.15
"""Share of the time of all cores in which nothing runs but what gives way."""

LONGEST_S = 120.0
"""Then a test begins all the same."""

TIMES = Path('/proc/stat')
"""Where the kernel counts what the cores did."""

_LOCK = LOCKS / 'bt_orchestrator_on_idle.lock'
"""One process looks at a time: what it starts is seen by the next one."""


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, bool, bool]:
    """Wait before a test, as long as its time limit does not run."""
    # Not by the environment: a test may start a pytest of its own.
    worker = getattr(item.config, 'workerinput', {}).get('workerid', '')
    if needs_idle(worker, os.environ.get(AT_ONCE, '')):
        wait_for_idle()
    return (yield)


def needs_idle(worker: str, at_once: str) -> bool:
    """Tell whether a process of this name is one of the further ones."""
    number = re.fullmatch(r'gw(\d+)', worker)
    return number is not None and at_once != '' and int(number[1]) >= int(at_once)


def wait_for_idle() -> None:
    """Return when the cores had time, or after a while."""
    with _LOCK.open('a') as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        deadline = time.monotonic() + LONGEST_S
        before = TIMES.read_text(encoding='ascii')
        while time.monotonic() < deadline:
            time.sleep(LOOK_S)
            now = TIMES.read_text(encoding='ascii')
            if idle_share(before, now) >= IDLE:
                return
            before = now


def idle_share(before: str, after: str) -> float:
    """Return the share of the time between two texts of `TIMES` in which nothing ran.

    What runs at a lower priority gives way to a test.
    """
    (start, was_idle), (other, is_idle) = (_spent(text) for text in (before, after))
    return (is_idle - was_idle) / max(other - start, 1)


def _spent(text: str) -> tuple[int, int]:
    """Return how long the cores were there, and how long they could be had."""
    spent = [int(word) for word in text.partition('\n')[0].split()[1:9]]
    _, nice, _, idle, waits_for_disk, *_ = spent
    return sum(spent), nice + idle + waits_for_disk
