"""The door that follows the cell, in a thread of its own, and the news that it hands over.

What happens is handed to the loop in batches, and the loop never waits for the node.
"""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

from bt_orchestrator.base.errors import NodeUnreachable
from bt_orchestrator.model.codec import to_text
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.ports import CellLink
from bt_orchestrator.ports.doors.open_door import FAREWELL_S, Ending, OpenDoor

STEP_S = 0.1
"""Longest time between two looks at whether to end."""

AGAIN_S = 1.0
"""Pause before another door is opened, when the node could not tell its events at the last one."""

STEADY_S = 5.0
"""A node that could not tell its events counts as silent until it has told them for so long."""

DEAF_S = 10.0
"""After such a silence the doors are opened anew. A process that stood still for longer than DDS
waits for a sign of life (20 s) does not hear the others again, nor do they hear it."""


class FollowingDoor:
    """Follows the cell for as long as the program runs. Implements `ports.Listener`."""

    def __init__(
        self, program: str, open_door: OpenDoor, tell: Callable[[Sequence[Fact]], object]
    ) -> None:
        """Prepare.

        :param program: its name, for that of the thread
        :param tell: called in the thread with what was heard, in order; hands it to the loop
        """
        self._open = open_door
        self._tell = tell
        self._facts: list[Fact] = []
        self._door: CellLink | None = None
        """None: there was none yet."""
        self._unheard_since: float | None = time.monotonic()
        """Since when the node is not followed; None: it is."""
        self._well_from = 0.0
        """When the node, which is followed again, counts as heard."""
        self._to_do: queue.SimpleQueue[Callable[[CellLink], object]] = queue.SimpleQueue()
        self._ending = threading.Event()
        self._thread = threading.Thread(
            target=self._run, name=f'{program}: following', daemon=True
        )
        self.error: BaseException | None = None
        """Why the thread ended by itself; None: it has not."""
        self.on_error: Callable[[], object] = _nothing
        self.on_deaf: Callable[[CellLink], object] = _nothing
        """Called in the thread with a door that will be closed, and another one opened."""
        self._place: Began | None = None
        """How far it has followed; None: it has not begun."""

    def start(self) -> None:
        """Begin to follow."""
        self._thread.start()

    @property
    def silent_s(self) -> float:
        """For how long nothing was heard of the node, seconds; from any thread."""
        since = self._unheard_since
        if since is not None:
            return time.monotonic() - since
        assert self._door is not None
        return self._door.silent_s

    def do(self, work: Callable[[CellLink], object]) -> None:
        """Have something done in the thread between two turns of its door; from any thread.

        :param work: waits for nothing
        """
        self._to_do.put(work)

    def end(self) -> None:
        """Ask the thread to end; it does within STEP_S."""
        self._ending.set()

    def join(self) -> None:
        """Wait for the end."""
        if self._thread.is_alive():
            self._thread.join(FAREWELL_S)

    # --- the listener -----------------------------------------------------------------------

    def on_status(self, status: CellStatus) -> None:
        """Take note."""
        self._facts.append(status)

    def on_event(self, event: Event) -> None:
        """Take note."""
        self._facts.append(Happened(event))
        self._go_on(event.seq)

    def on_gap(self, first: int, last: int) -> None:
        """Take note."""
        self._facts.append(Lost(first, last))
        self._go_on(last)

    def on_history(self, history: str) -> None:
        """Take note."""
        self._begin(history, 0)

    def _begin(self, history: str, last: int) -> Began:
        place = self._place = Began(history, last)
        self._facts.append(place)
        return place

    def _go_on(self, last: int) -> None:
        assert self._place is not None
        self._place = Began(self._place.history, last)

    # --- the thread -------------------------------------------------------------------------

    def _run(self) -> None:
        try:
            while True:
                with self._open(self._check) as door:
                    self._follow(door)
                    self._hear(door)
                    self.on_deaf(door)
        except Ending:
            pass
        except BaseException as error:  # noqa: BLE001 - it is told where the program was started
            self.error = error
            self.on_error()

    def _check(self) -> None:
        if self._ending.is_set():
            raise Ending

    def _follow(self, door: CellLink) -> None:
        """Begin to follow, however long the node is not there."""
        while True:
            self._check()
            try:
                place = self._place or self._begin_at_end(door)
                door.follow(self, place.last, place.history)
            except NodeUnreachable:
                self._ending.wait(STEP_S)
            else:
                self._door = door
                return

    def _begin_at_end(self, door: CellLink) -> Began:
        """Begin after what has happened so far."""
        status = door.status()
        # The status tells of an event a moment after it has happened, the journal at once.
        page = door.events_after(status.seq, 1)
        return self._begin(page.history, page.last_seq)

    def _hear(self, door: CellLink) -> None:
        """Hear what happens, until nothing is heard any more, or the node cannot tell it."""
        while door.silent_s < DEAF_S:
            self._check()
            if time.monotonic() >= self._well_from:
                self._unheard_since = None
            if not self._turn(door):
                self._unheard_since = self._unheard_since or time.monotonic()
                self._well_from = time.monotonic() + STEADY_S
                self._ending.wait(AGAIN_S)
                return
        self._unheard_since = time.monotonic() - door.silent_s

    def _turn(self, door: CellLink) -> bool:
        """Turn once, and hand on what was heard; tells whether the node can tell its events."""
        while not self._to_do.empty():
            self._to_do.get()(door)
        try:
            door.turn(STEP_S)
        except NodeUnreachable:
            return False
        finally:
            if self._facts:
                facts, self._facts = self._facts, []
                self._tell(facts)
        return True


def _nothing(*_: object) -> None:
    """Placeholder until somebody listens."""


# The news of a cell, in order.


@dataclass(frozen=True)
class Began:
    """A history, and the event after which its events follow."""

    history: str
    last: int


class Happened:
    """An event, with its record as JSON once somebody reads it."""

    def __init__(self, event: Event) -> None:
        self.first = self.last = event.seq
        self.event = event

    @cached_property
    def text(self) -> str:
        """The record."""
        return to_text(self.event)


class Lost:
    """Events that are lost for good: removed from the journal, or damaged."""

    def __init__(self, first: int, last: int) -> None:
        self.first = first
        self.last = last


Fact = Began | Happened | Lost | CellStatus
