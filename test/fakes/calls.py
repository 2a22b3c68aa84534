"""What some work costs, in a number that is the same on every machine."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any


def calls(work: Callable[[], object]) -> int:
    """Return how many calls some work makes, of Python and of C."""
    counted = 0

    def count(_: Any, event: str, __: Any) -> None:
        nonlocal counted
        counted += event in ('call', 'c_call')

    sys.setprofile(count)
    try:
        work()
    finally:
        sys.setprofile(None)
    return counted
