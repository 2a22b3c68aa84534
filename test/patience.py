"""How tests wait for what must come."""

from __future__ import annotations

import time
from collections.abc import Callable

PATIENCE_S = 120.0
"""Deadline of a condition: far more than it takes, also on a slow and busy machine."""

_LOOK_S = 0.02


def until(condition: Callable[[], object], what: str, within_s: float = PATIENCE_S) -> None:
    """Look at a condition until it holds; fails if it does not in time.

    :param what: what is waited for, for the reader of a failure
    """
    deadline = time.monotonic() + within_s
    while not condition():
        assert time.monotonic() < deadline, f'waited {within_s:g} s for {what}'
        time.sleep(_LOOK_S)
