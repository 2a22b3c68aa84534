"""The time of a node, as a port, the time since its machine started, and times as messages."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

from builtin_interfaces.msg import Time
from rclpy.node import Node

from bt_orchestrator.base.deadlines import NS_PER_S, Deadline, instant_ns
from bt_orchestrator.model.uptime import ClockReading, Uptime
from bt_orchestrator.ros.executor.alarms import Alarms


class RosClock:
    """System time, or simulated time with `use_sim_time`. Implements `ports.Clock`.

    Deadlines are on the steady clock, for the system's is set by people and by NTP. Where a node
    begins with `use_sim_time` they are in simulated time, which its simulation alone sets.

    To be used in the executor's thread.
    """

    def __init__(self, node: Node) -> None:
        self._clock = cast('Any', node.get_clock())
        self._is_simulated = bool(self._clock.ros_time_is_active)
        self._uptime = MachineUptime()
        make_timer = node.create_timer if self._is_simulated else None
        self._alarms = Alarms(node, self._steady_ns, make_timer)

    def now(self) -> float:
        """Return seconds since the epoch, or the simulated time."""
        if self._is_simulated:
            return float(self._clock.now().nanoseconds / NS_PER_S)
        return time.time()  # the same, at a tenth of the cost

    def steady(self) -> float:
        """Return seconds of the steady clock, or the simulated time."""
        return self._steady_ns() / NS_PER_S

    def uptime(self) -> Uptime | None:
        """Return how long the machine has been up; None with simulated time."""
        return None if self._is_simulated else self._uptime.now()

    def call_at(self, time: float, callback: Callable[[], None]) -> Deadline:
        """Call back once `steady()` has reached a time; never before this call has returned."""
        return self._alarms.call_at(instant_ns(time), callback)

    def close(self) -> None:
        """Forget all deadlines."""
        self._alarms.close()

    def _steady_ns(self) -> int:
        return int(self._clock.now().nanoseconds) if self._is_simulated else time.monotonic_ns()


# How long this machine has been up, as Linux tells it to every process alike.

_BOOT_ID = 'sys/kernel/random/boot_id'
_OFFSETS = 'self/timens_offsets'
_PROC = Path('/proc')


class MachineUptime:
    """The clock CLOCK_BOOTTIME, which goes on while the machine sleeps, and is never set.

    Containers share it, and the id of the boot, with their host.
    """

    def __init__(self, proc: Path = _PROC) -> None:
        """Find out the boot of this machine."""
        self._clock: int | None = getattr(time, 'CLOCK_BOOTTIME', None)
        self._boot = None if _has_its_own_time(proc) else _boot_id(proc)

    def now(self) -> Uptime | None:
        """Return the uptime; None: it cannot be known, or only this container goes by it."""
        if self._boot is None or self._clock is None:
            return None
        try:
            return Uptime(self._boot, round(time.clock_gettime(self._clock), 3))
        except OSError:  # a program such as faketime stands between, and has no such clock
            return None


def clock_reading() -> ClockReading | None:
    """Read the clocks of this machine, in any thread; None: its uptime cannot be known."""
    up = MachineUptime().now()
    return None if up is None else ClockReading(time.time(), up)


def _boot_id(proc: Path) -> str | None:
    try:
        return (proc / _BOOT_ID).read_text().strip() or None
    except OSError:
        return None


def _has_its_own_time(proc: Path) -> bool:
    """Tell whether this process is in a time namespace that counts from another moment."""
    try:
        lines = (proc / _OFFSETS).read_text().splitlines()
    except OSError:
        return False  # a kernel without time namespaces
    return any(offset.strip('0') for line in lines for offset in line.split()[1:])


# Seconds as messages, and back.


def to_time(seconds: float) -> Time:
    """Return seconds since the epoch as a message, to the nanosecond."""
    # Apart: nanoseconds since the epoch are more than the digits of a float.
    whole, part = divmod(seconds, 1.0)
    carried, rest = divmod(round(part * NS_PER_S), NS_PER_S)
    return Time(sec=int(whole) + carried, nanosec=rest)


def from_time(time: Time) -> float:
    """Return the seconds since the epoch of a message."""
    return float(time.sec + time.nanosec / NS_PER_S)


def to_moment(seconds: float | None) -> Time:
    """Return a time that may be absent; then it is zero."""
    return Time() if seconds is None else to_time(seconds)


def from_moment(time: Time) -> float | None:
    """Return the seconds since the epoch of a message; None: it is zero, there is no time."""
    return from_time(time) or None
