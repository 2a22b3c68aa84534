"""What a process has used, as the kernel counts it."""

from __future__ import annotations

import os
from pathlib import Path

_PAGE = os.sysconf('SC_PAGE_SIZE')


def cpu_s(pid: int) -> float:
    """Return the CPU seconds that the threads of a process have used, to the nanosecond."""
    threads = Path(f'/proc/{pid}/task').iterdir()
    return sum(int((thread / 'schedstat').read_text().split()[0]) for thread in threads) / 1e9


def memory_mb(pid: int) -> float:
    """Return the resident memory of a process.

    :raises OSError: it is gone
    """
    return int(Path(f'/proc/{pid}/statm').read_text().split()[1]) * _PAGE / 1e6


def family_cpu_s(pid: int) -> float:
    """Return the same of a process and its children, however deep."""
    return sum(map(cpu_s, family(pid)))


def family(pid: int) -> set[int]:
    """Return a process and its children, however deep.

    :raises OSError: one of them is gone
    """
    threads = Path(f'/proc/{pid}/task').iterdir()
    children = [int(child) for tid in threads for child in (tid / 'children').read_text().split()]
    return {pid}.union(*map(family, children))
