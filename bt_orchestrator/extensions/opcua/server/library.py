"""The library asyncua: the versions that fit, the memory it takes, its messages in our log."""

from __future__ import annotations

import ctypes
import gc
import logging
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.metadata import PackageNotFoundError, version

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.ports.spare_log import SpareLog

KNOWN = '2.1.'
"""Begin of the versions whose inside is overridden."""


class OpcUaUnusable(OrchestratorError):
    """The packages of the OPC UA server are missing; says what to install."""


def why_plain() -> str:
    """Say why the server must not use asyncua's inside; empty: it may.

    :raises OpcUaUnusable: there is none
    """
    try:
        release = version('asyncua')
    except PackageNotFoundError:
        raise OpcUaUnusable(
            "asyncua is needed, and not installed; install it with: pip install 'asyncua==2.1.*'"
        ) from None
    if release.startswith(KNOWN):
        return ''
    return f'asyncua {release} has another inside than {KNOWN}x, which is known'


# The messages of asyncua while it runs: in the log of the server, a line each, in limited number.
#
# Most of it is caused by clients; by itself it would go to the standard error, with tracebacks.

STACK = 'asyncua'


class _Passing(logging.Handler):
    def __init__(self) -> None:
        super().__init__(logging.WARNING)
        self._spare = SpareLog(logging.getLogger(__name__))

    def emit(self, record: logging.LogRecord) -> None:
        """Pass a record on."""
        message = record.getMessage()
        error = record.exc_info[1] if record.exc_info else None
        if error is not None:
            message += f': {type(error).__name__}: {error}'
        self._spare.warning(f'{STACK}: {message}')


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


# An address space is a quarter of a million objects, and building it leaves 30 MB over.


@contextmanager
def building() -> Iterator[None]:
    """Build what will stay: looking through it for garbage, again and again, costs most.

    Of several builds at once, the first that began has the collector on again.
    """
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()


def give_back() -> None:
    """Return memory that is not used to the system; nothing where malloc cannot.

    What is left stays until the next call, and is not looked through any more: clients would wait
    for it.
    """
    gc.unfreeze()
    gc.collect()
    gc.freeze()
    trim = getattr(ctypes.CDLL(None), 'malloc_trim', None)
    if trim is not None:
        trim(0)
