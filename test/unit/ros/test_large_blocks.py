"""What large messages took is given back."""

from __future__ import annotations

import subprocess
import sys

import pytest

_KEPT_MB = """
import os
from pathlib import Path
from bt_orchestrator.ros import memory

def used_mb():
    return int(Path('/proc/self/statm').read_text().split()[1]) * os.sysconf('SC_PAGE_SIZE') / 1e6

{first}
bytes(8 << 20)  # from now on glibc takes blocks of up to that size from the heap
before = used_mb()
large, small = [], []
for _ in range(100):
    large.append(b'x' * (1 << 20))
    small.append(b'x' * 20_000)
large.clear()
print(used_mb() - before)
"""


def kept_mb(first: str) -> float:
    """Return what a process keeps of 100 MB after it did something first."""
    program = _KEPT_MB.format(first=first)
    done = subprocess.run(
        [sys.executable, '-c', program], stdout=subprocess.PIPE, text=True, check=True
    )
    return float(done.stdout)


@pytest.mark.skipif(sys.platform != 'linux', reason='malloc of other systems is another one')
def test_large_blocks_between_small_ones_are_given_back() -> None:
    assert kept_mb('pass') > 80.0  # or else there is nothing to be done
    assert kept_mb('memory.give_back()') < 20.0
