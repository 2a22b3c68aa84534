"""The last events of a cell, for readers who come back."""

from __future__ import annotations

from bisect import bisect_right

from bt_orchestrator.ports.doors.facts import Happened, Lost

MOST_KEPT = 20_000
"""Events; readers who were away for longer have theirs fetched from the node."""

MOST_IN_ONE = 200
"""Most events in one message."""


class Ring:
    """Events of one history without a hole, in order; what is lost stands there as lost."""

    def __init__(self, last: int = 0) -> None:
        """Begin.

        :param last: the event before the first one to keep
        """
        self._before = last
        self._kept: list[Happened | Lost] = []
        self._lasts: list[int] = []

    @property
    def before(self) -> int:
        """The number before the first event that is kept."""
        return self._before

    @property
    def last(self) -> int:
        """The newest event."""
        return self._lasts[-1] if self._lasts else self._before

    def add(self, entry: Happened | Lost) -> None:
        """Add what comes next."""
        self._kept.append(entry)
        self._lasts.append(entry.last)
        if len(self._kept) > MOST_KEPT + MOST_KEPT // 8:  # not one by one: that moves all others
            old = len(self._kept) - MOST_KEPT
            self._before = self._lasts[old - 1]
            del self._kept[:old], self._lasts[:old]

    def entries(self) -> list[Happened | Lost]:
        """Return everything that is kept, oldest first."""
        return list(self._kept)

    def after(self, seq: int) -> Lost | list[Happened]:
        """Return what follows an event: some events, or that some are lost.

        :param seq: not older than `before`
        """
        place = bisect_right(self._lasts, seq)
        found: list[Happened] = []
        for entry in self._kept[place : place + MOST_IN_ONE]:
            if isinstance(entry, Lost):
                return found or entry
            found.append(entry)
        return found
