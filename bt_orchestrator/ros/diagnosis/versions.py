"""The installed rclpy and middleware, and the facts about them."""

from __future__ import annotations

import subprocess
import sys
from importlib import metadata, util

from bt_orchestrator.base.diagnosis.check import Check, fail, ok, warn
from bt_orchestrator.base.diagnosis.machine import number

TRIED = 'rmw_fastrtps_cpp'
"""The middleware that the tests run on."""

LOAD_S = 60.0
"""Longest time for that."""

_LOAD = """
from rclpy.utilities import get_rmw_implementation_identifier
print(get_rmw_implementation_identifier())
"""

FUTURES_FIXED = (9, 1, 3)
"""From this rclpy on, its action client does not keep a future of every goal."""


def rclpy_version() -> Check:
    """Look at rclpy; says how its known faults are met."""
    try:
        found = metadata.version('rclpy')
    except metadata.PackageNotFoundError:
        return warn('rclpy', 'of unknown version', 'install ROS 2 from its packages')
    if number(found) < FUTURES_FIXED:
        found += '; its action client keeps a future of every goal: worked around'
    return ok('rclpy', found)


def middleware() -> Check:
    """Load the RMW implementation, in another process: a wrong one ends the process it is in."""
    words = [sys.executable, '-c', _LOAD]
    done = subprocess.run(words, capture_output=True, text=True, timeout=LOAD_S, check=False)
    found = done.stdout.strip()
    if done.returncode or not found:
        said = done.stderr.strip().splitlines()
        remedy = 'install the package that RMW_IMPLEMENTATION names, or unset it'
        return fail('middleware', f'cannot be loaded: {said[-1] if said else "no reason"}', remedy)
    if found == TRIED:
        return ok('middleware', found)
    remedy = f'this package is tested on {TRIED}: export RMW_IMPLEMENTATION={TRIED}'
    return warn('middleware', found, remedy)


def executors() -> Check:
    """Say which values of the parameter `executor` work here; needs a middleware."""
    try:
        found = util.find_spec('rclpy.experimental.events_executor')
    except ModuleNotFoundError:
        found = None
    return ok('executors', 'single, events' if found else 'single (this rclpy has no events)')
