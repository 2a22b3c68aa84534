"""Memory of the process of a tree node: garbage, large blocks, and room for messages."""

from __future__ import annotations

import contextlib
import ctypes
import gc
import os
import socket
from collections.abc import Iterator
from pathlib import Path

NEW_OBJECTS = 20_000
"""A look at the new ones after so many; 4 MB at most would be garbage."""

OLDER_LOOKS = 20
"""Looks at one generation for each at the next older one."""


def collect_rarely() -> None:
    """Keep what is there out of all further looks; call it when everything has been made."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(NEW_OBJECTS, OLDER_LOOKS, OLDER_LOOKS)


# Memory of large messages goes back to the system at once when they are gone.
#
# Once a block was freed, glibc takes further ones of its size, up to 32 MB, from its heaps, and a
# heap shrinks no further than to the last small block in it. With results of 1 MB the process
# would keep three times the memory for good.

LARGE_BLOCK = 256 << 10
"""Bytes of a block that is a mapping of its own."""

_MMAP_THRESHOLD = -3
"""Its name in malloc.h. Once it is set, glibc does not adapt it any more."""


def give_back() -> None:
    """Let each large block be a mapping of its own from now on; nothing where malloc has none."""
    mallopt = getattr(ctypes.CDLL(None), 'mallopt', None)
    if mallopt is not None:
        mallopt(_MMAP_THRESHOLD, LARGE_BLOCK)


# Room for what peers send while this process is busy.
#
# A datagram that finds the buffer of its socket full is lost. DDS sends it again, but by default
# only after up to three seconds (`fast_dds.py`), and an answer in it comes so late. The kernel's
# default of 208 kB is filled by one request of that size, or by some hundred small ones at once.

WANTED_BYTES = 4 << 20
"""Bytes; the kernel gives as many as net.core.rmem_max allows."""


def widen_buffers() -> None:
    """Widen the buffers of all UDP sockets of this process; called once the node is made.

    A profile of Fast DDS could say it only where rmw_fastrtps takes the built-in transports: with
    a discovery range of LOCALHOST it makes its own.
    """
    for sock in _sockets():
        if sock.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF) < WANTED_BYTES:
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, WANTED_BYTES)


def _sockets() -> Iterator[socket.socket]:
    """Yield the UDP sockets of this process, each open while it is looked at."""
    for entry in Path('/proc/self/fd').iterdir():
        with contextlib.suppress(OSError):  # it is none, or was closed meanwhile
            if not str(entry.readlink()).startswith('socket:'):
                continue
            with socket.socket(fileno=os.dup(int(entry.name))) as sock:
                if sock.family == socket.AF_INET and sock.type == socket.SOCK_DGRAM:
                    yield sock
