"""Follow the events of a cell without gaps, although messages may be lost."""

from __future__ import annotations

from bt_orchestrator.model.events import Event
from bt_orchestrator.ports import EventPage, Listener

MOST_AHEAD = 1_000
"""Events that are buffered while earlier ones are missing; further ones are fetched later."""


class Follower:
    """Passes every event to one listener once and in order, whether received or fetched.

    A jump in the numbers, or a status with a later number, shows a gap: `next_fetch` then says
    what to fetch. Numbers count within one history: a new history means that the cell has another
    journal, and following restarts from its first event. Nothing here blocks.
    """

    def __init__(self, listener: Listener, history: str, last: int) -> None:
        """Begin.

        :param history: that the listener knows
        :param last: its last event that the listener knows
        """
        self._listener = listener
        self._history = history
        self._last = last
        self._newest = last
        """The highest event number that was received or reported."""
        self._ahead: dict[int, Event] = {}
        """Received events whose predecessors are still missing."""
        self._left: set[str] = set()
        """Histories of nodes that are gone; late messages of them may still arrive."""
        self._is_asked_for = False
        self._must_wait = False
        """The last fetch returned nothing: the next one waits for a new message."""

    def heard(self, history: str, event: Event) -> None:
        """Take in an event, the next one or not."""
        if not self._goes_on(history, event.seq):
            return
        if event.seq > self._last and len(self._ahead) < MOST_AHEAD:
            self._ahead[event.seq] = event
        self._tell_next()

    def told(self, history: str, seq: int) -> None:
        """Take in the number of the last event, from a status."""
        self._goes_on(history, seq)

    def next_fetch(self) -> int | None:
        """Return the number after which events must be fetched now; None: no fetch is needed.

        It is not returned again before `fetched` or `not_fetched` is called.
        """
        is_complete = self._last >= self._newest or self._last + 1 in self._ahead
        if is_complete or self._is_asked_for or self._must_wait:
            return None
        self._is_asked_for = True
        return self._last

    def fetched(self, page: EventPage) -> None:
        """Take in the journal page that `next_fetch` asked for."""
        self._is_asked_for = False
        self._must_wait = page.history != self._history or not page.events
        if page.history != self._history:
            return  # already of another node, whose own messages report it
        first = page.events[0].seq if page.events else page.first_seq
        if first > self._last + 1:
            lost, self._last = self._last + 1, first - 1
            self._listener.on_gap(lost, self._last)
        self._ahead = {seq: event for seq, event in self._ahead.items() if seq > self._last}
        self._ahead |= {event.seq: event for event in page.events}
        self._tell_next()

    def not_fetched(self) -> None:
        """Note that the node did not answer."""
        self._is_asked_for, self._must_wait = False, True

    def _goes_on(self, history: str, seq: int) -> bool:
        """Tell whether a history is the present one; a new one becomes the present one."""
        if history in self._left:
            return False
        if history != self._history:
            self._left.add(self._history)
            self._history, self._last, self._newest = history, 0, 0
            self._ahead.clear()
            self._listener.on_history(history)
        self._newest = max(self._newest, seq)
        self._must_wait = False
        return True

    def _tell_next(self) -> None:
        while (event := self._ahead.pop(self._last + 1, None)) is not None:
            self._last = event.seq
            self._listener.on_event(event)
