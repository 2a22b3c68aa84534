"""Memory of large messages goes back to the system at once when they are gone.

Once a block was freed, glibc takes further ones of its size, up to 32 MB, from its heaps, and a
heap shrinks no further than to the last small block in it. With results of 1 MB the process
would keep three times the memory for good.
"""

from __future__ import annotations

import ctypes

LARGE = 256 << 10
"""Bytes of a block that is a mapping of its own."""

_MMAP_THRESHOLD = -3
"""Its name in malloc.h. Once it is set, glibc does not adapt it any more."""


def give_back() -> None:
    """Let each large block be a mapping of its own from now on; nothing where malloc has none."""
    mallopt = getattr(ctypes.CDLL(None), 'mallopt', None)
    if mallopt is not None:
        mallopt(_MMAP_THRESHOLD, LARGE)
