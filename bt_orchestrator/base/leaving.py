"""A limit for the last thing that a process does: to let go of the middleware."""

from __future__ import annotations

import faulthandler
from collections.abc import Iterator
from contextlib import contextmanager

LEAVING_S = 20.0
"""Far more than it ever takes, on a busy machine too."""

_STDERR = 2


@contextmanager
def leaving() -> Iterator[None]:
    """Let go of the middleware in time, or be ended with status 1 and a stack trace on stderr.

    The destructors of a DDS may wait for each other for ever. They may do so while their thread
    holds Python's lock, so no thread of Python can watch over them; faulthandler's is none. What
    is to be written or told must be so before. Only for processes that end: it ends them.
    """
    faulthandler.dump_traceback_later(LEAVING_S, exit=True, file=_STDERR)
    try:
        yield
    finally:
        faulthandler.cancel_dump_traceback_later()
