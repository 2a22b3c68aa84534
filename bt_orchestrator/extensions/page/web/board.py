"""The present knowledge of the cell: its parts with versions, its last events, its readers.

A reader is a cursor here and nothing else, so one that is slow costs nothing. A message is encoded
once, however many read it.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from bt_orchestrator.extensions.page.web import messages
from bt_orchestrator.model.by import named
from bt_orchestrator.model.events import Event, OperatorDecided
from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.ports.doors.following_door import Happened, Lost

MOST_MESSAGES = 32
"""Messages that are kept encoded: readers stand at nearly the same place."""


@dataclass
class Cursor:
    """How far one reader is."""

    history: str
    seq: int
    """Last event that it has."""
    version: int = 0
    """Of the parts; 0: it has none."""


@dataclass(frozen=True)
class _Part:
    value: object
    text: str
    version: int


class Board:
    """All calls come from the loop's thread."""

    def __init__(self) -> None:
        self.history = ''
        """Empty: nothing was heard yet."""
        self.status: CellStatus | None = None
        """The newest one of this history."""
        self.version = 0
        """Counts the changes of parts; it goes on through all histories."""
        self.ring = Ring()
        self._parts: dict[str, _Part] = {}
        self._gone: dict[str, int] = {}
        """Version in which a part went, of those that a reader may still have."""
        self._encoded: dict[tuple[str, int, int], bytes] = {}

    # --- what comes in ----------------------------------------------------------------------

    def begin(self, history: str, last: int) -> None:
        """Forget everything: the cell has another journal.

        :param last: the event after which events will come
        """
        self.history = history
        self.status = None
        self.ring = Ring(last)
        self._parts.clear()
        self._gone.clear()
        self._encoded.clear()

    def put(self, parts: Mapping[str, object]) -> None:
        """Take in all present parts; those that did not change keep their version."""
        before, version = self._parts, self.version + 1
        now: dict[str, _Part] = {}
        for key, value in parts.items():
            known = before.get(key)
            is_same = known is not None and known.value == value
            now[key] = (
                known if is_same and known else _Part(value, messages.encoded(value), version)
            )
        gone = before.keys() - now.keys()
        if gone or any(part.version == version for part in now.values()):
            self.version = version
            self._parts = now
            self._gone = {k: v for k, v in self._gone.items() if k not in now}
            self._gone |= dict.fromkeys(gone, version)

    def forget_gone(self, oldest: int) -> None:
        """Forget which parts went, up to a version that every reader has."""
        self._gone = {key: version for key, version in self._gone.items() if version > oldest}

    # --- what readers get -------------------------------------------------------------------

    @property
    def newest(self) -> int:
        """The last event that the parts may tell of."""
        return max(self.ring.last, self.status.seq if self.status else 0)

    def start(self, history: str, seq: int | None) -> Cursor:
        """Return where a reader begins.

        :param seq: the last event that it has; None: only what happens from now on
        """
        goes_on = seq is not None and history == self.history
        return Cursor(self.history, seq if goes_on and seq is not None else self.newest)

    def is_behind(self, cursor: Cursor) -> bool:
        """Tell whether a reader needs older events than are kept here."""
        return cursor.seq < self.ring.before

    def next_events(self, cursor: Cursor) -> bytes | None:
        """Return the next message of events, and move on; None: this is the end for now."""
        if cursor.seq >= self.ring.last:
            return None
        key = ('happened', cursor.seq, self.ring.last)
        news = self.ring.after(cursor.seq)
        cursor.seq = news.last if isinstance(news, Lost) else news[-1].last
        if (known := self._encoded.get(key)) is None:
            known = self.told(news)
            self._keep(key, known)
        return known

    def told(self, news: Lost | list[Happened]) -> bytes:
        """Return a message of events, or of a gap in them."""
        if isinstance(news, Lost):
            return messages.gap(self.history, news.first, news.last)
        names = _names(entry.event for entry in news)
        return messages.happened(
            self.history, news[-1].last, (entry.text for entry in news), names
        )

    def next_parts(self, cursor: Cursor) -> bytes | None:
        """Return a message of the parts that changed since, and move on; None: none did."""
        if cursor.version >= self.version or not self._parts:
            return None
        key = ('parts', cursor.version, self.version)
        if (known := self._encoded.get(key)) is None:
            after = cursor.version
            changed = {k: part.text for k, part in self._parts.items() if part.version > after}
            gone = [k for k, version in self._gone.items() if version > after] if after else []
            known = messages.parts(self.version, changed, gone)
            self._keep(key, known)
        cursor.version = self.version
        return known

    def _keep(self, key: tuple[str, int, int], text: bytes) -> None:
        if len(self._encoded) >= MOST_MESSAGES:
            self._encoded.pop(next(iter(self._encoded)))
        self._encoded[key] = text


def _names(events: Iterable[Event]) -> dict[str, str]:
    """Return the names for display of those who decided something, by sequence number."""
    decided = (event for event in events if isinstance(event, OperatorDecided) and event.who)
    return {str(event.seq): named(event.who, event.known) for event in decided}


# The last events of a cell, for readers who come back.

MOST_EVENTS_KEPT = 20_000
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
        if (
            len(self._kept) > MOST_EVENTS_KEPT + MOST_EVENTS_KEPT // 8
        ):  # not one by one: that moves all others
            old = len(self._kept) - MOST_EVENTS_KEPT
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
        entries: list[Happened] = []
        for entry in self._kept[place : place + MOST_IN_ONE]:
            if isinstance(entry, Lost):
                return entries or entry
            entries.append(entry)
        return entries
