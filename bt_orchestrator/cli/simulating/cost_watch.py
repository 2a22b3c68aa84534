"""Memory of a virtual run: the run ends with a message before it takes all of it."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.model.events import BeatStarted, BeltIndexed, Event

_LOOK_EVERY = 1_000
"""Beats between two looks."""

_SHARE = 0.5
"""Of the memory that is free when the run begins."""

_WITHOUT_PROC_BYTES = 2e9
"""The limit where Linux does not tell what is free."""


class TooCostly(OrchestratorError):
    """A virtual run needs more memory than it may take."""


class CostWatch:
    """Counts beats, and looks now and then at what they took. Implements `ports.EventSink`."""

    def __init__(
        self,
        items: int,
        limit_bytes: float | None = None,
        used_bytes: Callable[[], float] | None = None,
    ) -> None:
        """Begin.

        :param items: how many are to be run in all
        :param limit_bytes: what the run may take; without it a share of what is free now
        :param used_bytes: what the process takes
        """
        self._items = items
        self._limit = _SHARE * _free_bytes() if limit_bytes is None else limit_bytes
        self._used = used_bytes or _used_bytes
        self._before = self._used()
        self._began = time.monotonic()
        self._beats = 0
        self._looked = 0

    def publish(self, events: Sequence[Event]) -> None:
        """Count beats: an item is begun in each, or fewer."""
        self._beats += sum(isinstance(event, (BeltIndexed, BeatStarted)) for event in events)

    def look(self) -> None:
        """Go on, or give up.

        :raises TooCostly: the run would take too much memory, or does
        """
        if self._beats < self._looked + _LOOK_EVERY:
            return
        self._looked = self._beats
        taken = self._used() - self._before
        if max(taken, taken / self._beats * self._items) > self._limit:
            raise TooCostly(self._in_words(taken))

    def _in_words(self, taken: float) -> str:
        share = self._items / self._beats
        hours = (time.monotonic() - self._began) * share / 3600
        return (
            f'{self._items} items would take about {_gigabytes(taken * share)} of memory and '
            f'{hours:.1f} hours; this run may take {_gigabytes(self._limit)}, half of what is '
            f'free, and ended after {self._beats} beats; order fewer: time per item and '
            'bottleneck are the same for 1000 items'
        )


def _gigabytes(number: float) -> str:
    return f'{number / 1e9:,.1f} GB'


def _used_bytes() -> float:
    try:
        pages = int(Path('/proc/self/statm').read_text(encoding='ascii').split()[1])
    except (OSError, ValueError, IndexError):
        return 0.0
    return float(pages * os.sysconf('SC_PAGE_SIZE'))


def _free_bytes() -> float:
    try:
        lines = Path('/proc/meminfo').read_text(encoding='ascii').splitlines()
        (free,) = (line.split()[1] for line in lines if line.startswith('MemAvailable:'))
        return float(free) * 1024
    except (OSError, ValueError):
        return _WITHOUT_PROC_BYTES
