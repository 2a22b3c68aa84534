"""How long this machine has been up, as Linux tells it to every process alike."""

from __future__ import annotations

import time
from pathlib import Path

from bt_orchestrator.model.uptime import Uptime

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
