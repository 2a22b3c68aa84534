"""The cells of a plant, as its database tells of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple


class PlantCell(NamedTuple):
    """How a cell stood when its last events came."""

    name: str
    state: str
    """PackML state; empty: not known yet."""
    state_since: float | None
    """Seconds since the epoch."""
    stop_reason: str
    """own_fault, say (semantics 7.2); empty: none."""
    last_seq: int
    last_event: float | None
    """Time of its last event."""
    behind_s: float | None
    """Seconds since the writer knew that nothing was missing; None: it never did."""
    gaps: int
    """Stretches of events that will never come."""
    page: str
    """Address of its operator page; empty: not known."""


PlantCells = Callable[[], Sequence[PlantCell]]
"""Reads the cells, in the order of their names; raises JournalUnusable."""
