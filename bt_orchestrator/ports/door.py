"""The door to a running cell, for people and machines outside."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, Protocol

from bt_orchestrator.model.branch import Branch
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.requests import Asked
from bt_orchestrator.model.status import CellDescription, CellStatus, JobStatus, ListedJob


class EventPage(NamedTuple):
    """Consecutive events of one history."""

    history: str
    events: Sequence[Event]
    """Oldest first; empty: this is the end for now."""
    first_seq: int
    """The oldest that is available; earlier ones were removed, or are damaged."""
    last_seq: int
    """The newest durable one."""


class Moment(NamedTuple):
    """A state of a cell from which a virtual run can begin."""

    cell: Cell
    plain_state: Mapping[str, Any]
    """Of `model.keeping.snapshot`."""
    now_s: float
    """Time of the state, on its clock."""
    observed_s: Mapping[str, Mapping[str, float]] = {}
    """Seconds that tasks took, by component and task constant."""


class QueuePage(NamedTuple):
    """Consecutive jobs of the queue."""

    jobs: Sequence[JobStatus]
    queued: int
    """Length of the whole queue."""


class Listener(Protocol):
    """Receives what happens in a cell: called from `CellLink.turn`, in one thread."""

    def on_status(self, status: CellStatus) -> None:
        """Receive the latest status of the cell; intermediate ones may be skipped."""

    def on_event(self, event: Event) -> None:
        """Receive every event once, in the order of their numbers."""

    def on_gap(self, first: int, last: int) -> None:
        """Receive the range of events that are lost for good: removed, or damaged."""

    def on_history(self, history: str) -> None:
        """The cell has another journal: numbers restart, and what was known is void."""


class Watch(Protocol):
    """Something that a door looks at for a listener, as long as it is open."""

    def close(self) -> None:
        """Stop looking; harmless when it is closed. The listener is not called again."""


class CellLink(Protocol):
    """The door to one running cell: everything that clients see of it and request from it.

    All calls come from one thread. What happens between calls is kept for the next `turn`.

    Where another thread runs a loop of its own (asyncio, say), one thread has the door and calls
    `turn` again and again; its listener hands each fact, all of them frozen, to the loop with
    `call_soon_threadsafe`, and the loop hands requests over in a queue that this thread empties
    between two turns. Two threads that want to ask at the same time have a door each.
    """

    @property
    def name(self) -> str:
        """Name of the cell's tree node, for instance /bt_orchestrator."""

    def status(self) -> CellStatus:
        """Return the status of the cell.

        :raises NodeUnreachable: nothing is heard of it
        """

    def description(self) -> CellDescription:
        """Return the parts of the cell.

        :raises NodeUnreachable: nothing is heard of it
        """

    def follow(self, listener: Listener, after_seq: int | None = None, history: str = '') -> None:
        """Send a listener everything from an event on, without gaps, across restarts of the node.

        Each call adds a listener. It is first called in the next `turn`.

        :param after_seq: last event that the listener knows; None: only what happens from now on
        :param history: history of `after_seq`; empty: the present one. If the cell has another
            one, `on_history` is called first, then everything from its first event
        :raises NodeUnreachable: nothing is heard of the node
        """

    def watch_tree(self, hear: Callable[[Branch], None]) -> Watch:
        """Send the behaviour tree of now, and again whenever it has changed, in `turn`.

        It is large, and costs the node work as long as the watch is open. It goes on across
        restarts of the node, and nothing is raised while the node is away.
        """

    def turn(self, within_s: float) -> None:
        """Handle what arrives within a time: this calls the listeners.

        It returns early when it has called a listener. Nothing is raised while the node is away:
        then `silent_s` grows. A listener may close the door.

        :raises NodeUnreachable: the node is there, and says that it cannot read its journal
        """

    @property
    def silent_s(self) -> float:
        """Seconds since the last message of the node.

        The node sends a message once a second, whether anything happens or not. So after some
        seconds of silence the node is away. It counts while there is a listener.
        """

    def events_after(self, seq: int, most: int = 0) -> EventPage:
        """Return events from the journal of the cell, as many as fit in one answer.

        :param most: maximum number; 0: as many as fit
        :raises NodeUnreachable: it does not answer, or cannot read its journal
        """

    def queue(self, after: str = '', most: int = 0) -> QueuePage:
        """Return jobs of the queue, in order.

        :param after: the job before the first to return; empty: from the first
        :raises CommandRefused: that job is not in the queue (any more)
        :raises NodeUnreachable: it does not answer
        """

    def jobs(self, after: str = '', most: int = 0) -> Sequence[ListedJob]:
        """Return listed jobs: the last that ended, oldest first, those on the line, the queue.

        :param after: the job before the first to return; empty: from the first
        :param most: maximum number; 0: as many as fit in one answer
        :raises CommandRefused: that job is not listed (any more)
        :raises NodeUnreachable: it does not answer
        """

    def job(self, name: str) -> ListedJob:
        """Return a listed job.

        :raises CommandRefused: it is not listed (any more)
        :raises NodeUnreachable: it does not answer
        """

    def moment(self) -> Moment:
        """Return the state of now, for a virtual run that begins with it.

        Of a long queue it has the first jobs (`model.limits`).

        :raises NodeUnreachable: it does not answer, or cannot tell its state at this moment
        """

    def ask(self, asked: Asked) -> Answer:
        """Send a request to the cell and wait for its answer, which is then on record.

        :raises NodeUnreachable: it does not answer; whether it was carried out is unknown
        """

    def close(self) -> None:
        """Disconnect; the cell is not affected."""
