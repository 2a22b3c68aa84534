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
        version = metadata.version('rclpy')
    except metadata.PackageNotFoundError:
        return warn('rclpy', 'of unknown version', 'install ROS 2 from its packages')
    if number(version) < FUTURES_FIXED:
        version += '; its action client keeps a future of every goal: worked around'
    return ok('rclpy', version)


def middleware() -> Check:
    """Load the RMW implementation, in another process: a wrong one ends the process it is in."""
    words = [sys.executable, '-c', _LOAD]
    done = subprocess.run(words, capture_output=True, text=True, timeout=LOAD_S, check=False)
    name = done.stdout.strip()
    if done.returncode or not name:
        lines = done.stderr.strip().splitlines()
        remedy = 'install the package that RMW_IMPLEMENTATION names, or unset it'
        return fail(
            'middleware', f'cannot be loaded: {lines[-1] if lines else "no reason"}', remedy
        )
    if name == TRIED:
        return ok('middleware', name)
    remedy = f'this package is tested on {TRIED}: export RMW_IMPLEMENTATION={TRIED}'
    return warn('middleware', name, remedy)


def executors() -> Check:
    """Say which values of the parameter `executor` work here; needs a middleware."""
    try:
        spec = util.find_spec('rclpy.experimental.events_executor')
    except ModuleNotFoundError:
        spec = None
    return ok('executors', 'single, events' if spec else 'single (this rclpy has no events)')
