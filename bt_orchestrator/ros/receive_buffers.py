"""Room for what peers send while this process is busy.

A datagram that finds the buffer of its socket full is lost. DDS sends it again, but by default
only after up to three seconds (`fast_dds.py`), and an answer in it comes so late. The kernel's
default of 208 kB is filled by one request of that size, or by some hundred small ones at once.
"""

from __future__ import annotations

import contextlib
import os
import socket
from collections.abc import Iterator
from pathlib import Path

WANTED = 4 << 20
"""Bytes; the kernel gives as many as net.core.rmem_max allows."""


def widen() -> None:
    """Widen the buffers of all UDP sockets of this process; called once the node is made.

    A profile of Fast DDS could say it only where rmw_fastrtps takes the built-in transports: with
    a discovery range of LOCALHOST it makes its own.
    """
    for one in _sockets():
        if one.getsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF) < WANTED:
            one.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, WANTED)


def _sockets() -> Iterator[socket.socket]:
    """Yield the UDP sockets of this process, each open while it is looked at."""
    for entry in Path('/proc/self/fd').iterdir():
        with contextlib.suppress(OSError):  # it is none, or was closed meanwhile
            if not str(entry.readlink()).startswith('socket:'):
                continue
            with socket.socket(fileno=os.dup(int(entry.name))) as one:
                if one.family == socket.AF_INET and one.type == socket.SOCK_DGRAM:
                    yield one
