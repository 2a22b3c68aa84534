"""An address space is a quarter of a million objects, and building it leaves 30 MB over."""

from __future__ import annotations

import ctypes
import gc
from collections.abc import Iterator
from contextlib import contextmanager


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
