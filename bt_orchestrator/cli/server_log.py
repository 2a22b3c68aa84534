"""The output of a server while it runs: one line for each login, command and error."""

from __future__ import annotations

import logging
import sys
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def server_log(room: str) -> Iterator[None]:
    """Write to the standard error as long as the context is open.

    :param room: package whose log is written
    """
    log, handler = logging.getLogger(room), logging.StreamHandler(sys.stderr)
    handler.setFormatter(OneLine('%(asctime)s %(levelname)s %(message)s'))
    level = log.level
    log.setLevel(logging.INFO)
    log.addHandler(handler)
    try:
        yield
    finally:
        log.removeHandler(handler)
        log.setLevel(level)


class OneLine(logging.Formatter):
    """Keeps what others have written from looking like lines of the server."""

    def formatMessage(self, record: logging.LogRecord) -> str:  # noqa: N802 - of the base
        """Return the line; a traceback may follow."""
        return ''.join(
            char if char.isprintable() else repr(char)[1:-1]
            for char in super().formatMessage(record)
        )
