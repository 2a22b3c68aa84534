"""Limits the values of one state topic: it cannot flood the journal (2.5)."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import Any

from bt_orchestrator.model.allowance import Allowance
from bt_orchestrator.model.codec import json_of
from bt_orchestrator.model.limits import (
    STATE_VALUE_BYTES,
    STATE_VALUE_SHORT,
    STATES_OF_ONE,
    shortened,
)

_RECORD_BYTES = 200
"""Bytes of a record without the value."""


class StateFlow:
    """Tells every change while there are not too many, else the newest value when it may.

    That a component is not ready any more is told at once, whatever came before. Every time is one
    of a steady clock.
    """

    def __init__(self, ready: Collection[Any]) -> None:
        """Begin.

        :param ready: the values that mean ready
        """
        self._ready = ready
        self._allowance = Allowance(STATES_OF_ONE)
        self._newest: Any = None
        self._told: Any = None

    @property
    def is_waiting(self) -> bool:
        """Tell whether the newest value was not told yet."""
        return not _same(self._newest, self._told)

    def hear(self, value: Any, now: float) -> Iterator[Any]:
        """Take the newest value; yield the values that are due now."""
        self._newest = value
        yield from self.look(now)

    def look(self, now: float) -> Iterator[Any]:
        """Yield the newest value if it waits and is due."""
        if not self.is_waiting:
            return
        left = self._allowance.left(now)
        for kept in self._forms():
            size = _RECORD_BYTES + len(json_of(kept))
            if size <= left or self._must_be_told(kept):
                self._allowance.use(size, now)
                self._told = self._newest
                yield kept
                return

    def _forms(self) -> Iterator[Any]:
        """Yield the value as it may be kept, and shorter."""
        if self._newest in self._ready:
            yield self._newest
            return
        whole = shortened(self._newest, STATE_VALUE_BYTES)
        yield whole
        yield shortened(whole, STATE_VALUE_SHORT)

    def _must_be_told(self, kept: Any) -> bool:
        ends = self._told in self._ready and self._newest not in self._ready
        return ends and len(json_of(kept)) <= 8 * STATE_VALUE_SHORT


def _same(one: Any, other: Any) -> bool:
    """Tell whether two values are equal and of one type: 1 and True are equal in Python."""
    return type(one) is type(other) and bool(one == other)
