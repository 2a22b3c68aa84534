"""The messages of asyncua while it runs: in the log of the server, a line each, in limited number.

Most of it is caused by clients; by itself it would go to the standard error, with tracebacks.
"""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager

from bt_orchestrator.ports.spare_log import SpareLog

STACK = 'asyncua'


class _Passing(logging.Handler):
    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self._spare = SpareLog(logging.getLogger(__name__))

    def emit(self, record: logging.LogRecord) -> None:
        """Pass a record on."""
        said = record.getMessage()
        error = record.exc_info[1] if record.exc_info else None
        if error is not None:
            said += f': {type(error).__name__}: {error}'
        self._spare.warning(f'{STACK}: {said}')


@contextmanager
def stack_log() -> Iterator[None]:
    """Pass on what asyncua writes as long as the context is open."""
    log, handler = logging.getLogger(STACK), _Passing()
    propagates, log.propagate = log.propagate, False
    log.addHandler(handler)
    try:
        yield
    finally:
        log.removeHandler(handler)
        log.propagate = propagates
