"""The seams: what the orchestrator needs from the outside world, and nothing about how.

Every implementation of a port passes the contract tests of that port (test/contract).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import Any, NamedTuple, Protocol, TypeVar

from bt_orchestrator.model.action_type import ActionType
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.goal import GoalEnd, GoalRequest, SeenContest, StateReading
from bt_orchestrator.model.jobs.job_record import JobRecord
from bt_orchestrator.model.records import Extent, JobPlace, Page, Summaries, Wanted
from bt_orchestrator.model.requests import Asked
from bt_orchestrator.model.status import CellDescription, CellStatus, JobStatus
from bt_orchestrator.model.uptime import Uptime

_Result = TypeVar('_Result')
_Result_co = TypeVar('_Result_co', covariant=True)


class Goal(Protocol):
    """One goal at one action server.

    Its states: requested (`accepted` False, `end` None), accepted (`accepted` True, `end` None),
    ended (`end` set, for good). Only the gateway changes them.
    """

    @property
    def request(self) -> GoalRequest:
        """What was asked."""

    @property
    def accepted(self) -> bool:
        """True once the server said yes."""

    @property
    def end(self) -> GoalEnd | None:
        """How it ended; None while it has not."""

    @property
    def feedback(self) -> Mapping[str, Any] | None:
        """Fields of the last feedback message; None if none came."""

    def cancel(self) -> None:
        """Ask the server to cancel; returns at once and may be called again.

        A goal that is not accepted yet is cancelled on acceptance (semantics 2.4); one that waits
        for its server is withdrawn and ends CANCELED. A server may refuse: then nothing changes.
        """


Told = Goal | StateReading | SeenContest
"""What a gateway may have to tell."""


class Servers(Protocol):
    """What is seen of the action servers without asking them anything."""

    def available(self, component: str) -> bool:
        """Tell whether the component's action server was there at the last look, for show."""

    def rivals(self, component: str) -> Sequence[str]:
        """Return where the servers of a component's action are, if several are known now.

        Nothing is sent then: a request waits as if there were no server, and `drain` has told of
        it, or will (`SeenContest`). None of them is believed that it does not know a goal.
        """

    def server(self, component: str) -> str | None:
        """Return an id of the instance of the component's server that was seen last.

        A server that was restarted has another one, and the goals of the one before are unknown
        to it. It may be out of date, which only makes a proof fail that it is needed for
        (semantics 9.2). None: no server was seen, or several with one name.
        """


class ActionGateway(Servers, Protocol):
    """The one way to the robots. All calls come from the tick thread."""

    def listen(self, wake: Callable[[], None]) -> None:
        """Name the function that is called whenever `drain` has an end or a state topic.

        That a goal was accepted waits for the next call: nothing follows from it.
        """

    def send(self, request: GoalRequest) -> Goal:
        """Send one goal; returns at once, whatever the server does.

        A request whose server is not there waits for it, for the gateway's server timeout, and
        ends UNAVAILABLE after that.
        """

    def adopt(self, request: GoalRequest) -> Goal:
        """Take over a goal that was sent before, perhaps by another process (semantics 9.2).

        Only its UUID is asked for; nothing is sent. Running or finished: it becomes accepted and
        ends as the server says. LOST: the server does not know it, asked again after a while
        (`GoalEnd.denied_by` tells which instance said so), or no server came within the server
        timeout.
        """

    def drain(self) -> Sequence[Told]:
        """Return what is new since the last call, oldest first.

        A goal is listed when it was accepted and when it ended; a state topic when its field's
        value changed or its publisher vanished; a contest when it is another one.
        """


class ActionTypes(Protocol):
    """What the installed interface packages say about action and message types."""

    def action(self, name: str) -> ActionType:
        """Return the description of an action type such as pkg/action/Name.

        :raises UnknownActionType: it is not installed, or is no action type
        """

    def message_field(self, type_name: str, field: str) -> str:
        """Return the ROS name of the type of a message's field, for instance string.

        :raises UnknownActionType: the message type is not installed or has no such field
        """


class Timer(Protocol):
    """A deadline that was set."""

    def cancel(self) -> None:
        """Forget it; harmless when it has passed."""


class Clock(Protocol):
    """Time as a port: no logic reads a wall clock or sleeps."""

    def now(self) -> float:
        """Seconds: since the epoch in a real run, from 0 in a virtual one.

        For records. Somebody may set it, forward or back, so nothing is waited for by it.
        """

    def steady(self) -> float:
        """Seconds that nobody sets, from some beginning of this process's own."""

    def call_at(self, time: float, callback: Callable[[], None]) -> Timer:
        """Call back once, in the tick thread, when `steady()` has reached `time`."""

    def uptime(self) -> Uptime | None:
        """How long the machine has been up, for other processes to compare with theirs.

        None: it does not tell, or goes by another time.
        """


class Snapshot(NamedTuple):
    """What the state was after an event."""

    seq: int
    stamp: str
    """Which program wrote it, for which cell."""
    state: str
    """As JSON."""


class EventStore(Protocol):
    """The journal: the only durable truth."""

    @property
    def history(self) -> str:
        """Name the history that the events are of: random, and of no other journal.

        Numbers of events say something only within one.
        """

    @property
    def is_restored(self) -> bool:
        """Tell whether this history goes on from a copy of another one (semantics 9.2)."""

    def missing(self, after: int) -> str:
        """Tell, in words, what was written after an event and is not to be had; empty: nothing.

        :raises JournalUnusable: it cannot be read
        """

    def go_on_after(self, seq: int) -> None:
        """Let another history begin after an event, with the next `append`.

        What is missing was told to others under its numbers, and these get other events now.
        """

    def append(self, events: Sequence[Event]) -> None:
        """Make the events durable, all or none.

        :param events: one or more, with the numbers that come next
        :raises JournalFailed: none of them is
        """

    def read(self, after: int = 0, most: int = -1) -> Iterable[Event]:
        """Return the events with a seq greater than `after`, oldest first.

        Errors come when it is read so far.

        :param most: so many at most; -1: all
        :raises DamagedRecord: the next one cannot be read; those before it are as they were
        :raises JournalUnusable: nothing can be read any more
        """

    def first_seq(self) -> int:
        """Return the seq of the first event that is kept, or that is to come.

        :raises JournalUnusable: it cannot be read
        """

    def snapshots(self) -> Iterable[Snapshot]:
        """Return states to start from, newest first. Each is a cache and may be ignored."""

    def beginning(self) -> Snapshot | None:
        """Return the state that replay begins with; None: with the first event of all.

        :raises JournalUnusable: it is damaged, or cannot be read
        """


class Journal(EventStore, Protocol):
    """A journal that outlives its orchestrator, and is kept short for the next one."""

    def save(self, snapshot: Snapshot, ended: Sequence[JobRecord] = ()) -> None:
        """Keep a state to start from, and what is to stay of jobs that ended.

        :raises JournalFailed: neither is kept
        """

    def first_needed(self, live: Collection[str], keep_jobs: int) -> int:
        """Return the seq of the first event of any live job, or of the last `keep_jobs` others.

        0: there are not more jobs than that.

        :raises JournalFailed: it cannot be read
        """

    def begin_with(self, snapshot: Snapshot) -> None:
        """Let replay begin with a state: events up to it may be removed.

        :raises JournalFailed: nothing has changed
        """

    def remove_batch(self, before: int) -> bool:
        """Remove some of the first events before a seq, none that replay needs.

        :return: whether there are more
        :raises JournalFailed: none were removed
        """

    def close(self) -> None:
        """Let others have it."""


class Records(Protocol):
    """A journal as its readers see it, while it is written or when nobody has it.

    Nothing in it changes by reading. Each answer is of one moment and takes short, so that nobody
    who writes has to wait. What is damaged or missing is in the answer, never left out silently.
    Items are a fold of the records of their job (`report.reading`). One thread at a time.
    """

    def extent(self) -> Extent:
        """Tell how far it reaches.

        :raises JournalUnusable: it cannot be read
        """

    def page(self, wanted: Wanted, most: int = 1000) -> Page:
        """Return the next of the records that are wanted; go on with `Page.rest`.

        There may be fewer than `most`, or none, on a page that is not the last: a page ends as
        well when much was looked at.

        :raises JournalUnusable: it cannot be read
        """

    def summaries(
        self, after: JobPlace | None = None, most: int = 1000, *, newest_first: bool = False
    ) -> Summaries:
        """Return what is kept of jobs that ended, their events or not, as they were queued.

        :param after: where to go on (`Summaries.rest`); None: with the first of them
        :raises JournalUnusable: it cannot be read
        """

    def state_before(self, seq: int) -> Snapshot | None:
        """Return a state from which the moment after an event can be had by few events.

        None: there is none; then replay begins with the first event of all, if that is kept.

        :raises JournalUnusable: it cannot be read
        """

    def close(self) -> None:
        """Let go of it."""


class Writing(Protocol[_Result_co]):
    """Something that is being written."""

    def has_ended(self, within_s: float = 0.0) -> bool:
        """Tell whether it has ended, well or not; wait for that for so long at most."""

    def result(self) -> _Result_co:
        """Return what it returned once it has ended, or raise what it raised."""


class Writer(Protocol):
    """Who waits for a disk, so that others need not: one thing after the other, in their order."""

    def begin(self, write: Callable[[], _Result]) -> Writing[_Result]:
        """Have something written.

        Whoever was told that it has not ended is woken when it has.

        :param write: uses the journal, and nothing that changes meanwhile
        """


class EventSink(Protocol):
    """An output of the event stream; one that fails never stops the cell."""

    def publish(self, events: Sequence[Event]) -> None:
        """Hand on events that are durable, oldest first."""


class Foresight(Protocol):
    """Works out when jobs will end, apart from the tick thread."""

    def ask(self, state: str, observed_s: Mapping[str, Mapping[str, float]], now_s: float) -> None:
        """Ask for a forecast from a state on; returns at once. A later question replaces it.

        :param state: of `model.snapshot`, as JSON
        :param observed_s: seconds that tasks took, by component and task constant
        """

    @property
    def ends_s(self) -> Mapping[str, float]:
        """When each live job will end, by the last forecast; those unknown are left out."""

    def close(self) -> None:
        """Stop working."""


# --- the door: people and machines outside ------------------------------------------------------


class EventPage(NamedTuple):
    """Events of one history that follow each other."""

    history: str
    events: Sequence[Event]
    """Oldest first; empty: there are no more, for now."""
    first_seq: int
    """The oldest that can be had; those before it were removed, or are damaged."""
    last_seq: int
    """The newest that the node has kept."""


class Moment(NamedTuple):
    """One moment of a cell, from which a virtual run may begin."""

    cell: Cell
    plain_state: Mapping[str, Any]
    """Of `model.snapshot`."""
    now_s: float
    """On the clock of the state."""
    observed_s: Mapping[str, Mapping[str, float]] = {}
    """Seconds that tasks took, by component and task constant."""


class QueuePage(NamedTuple):
    """Jobs of the queue that follow each other."""

    jobs: Sequence[JobStatus]
    queued: int
    """How many there are in the whole queue."""


class Listener(Protocol):
    """Is told what happens in a cell: called from within `CellLink.turn`, in one thread."""

    def on_status(self, status: CellStatus) -> None:
        """Take in how the cell stands: the latest, not each one that there was."""

    def on_event(self, event: Event) -> None:
        """Take in what happened: every event, in the order of their numbers, each once."""

    def on_gap(self, first: int, last: int) -> None:
        """Learn that events are lost for good: they were removed, or are damaged."""

    def on_history(self, history: str) -> None:
        """Learn that the cell has another journal: numbers begin anew, what was known is void."""


class CellLink(Protocol):
    """The door to one running cell: all that people and machines outside see of it and ask of it.

    All calls come from one thread. Whatever happens between them is kept for the next `turn`.

    Where another thread runs a loop of its own (asyncio, say), one thread has the door and calls
    `turn` again and again; its listener hands each fact, all of them frozen, to the loop with
    `call_soon_threadsafe`, and the loop hands requests over in a queue that this thread empties
    between two turns. Two threads that want to ask at the same time have a door each.
    """

    @property
    def name(self) -> str:
        """Name of the cell's tree node, for instance /bt_orchestrator."""

    def status(self) -> CellStatus:
        """Return how the cell stands.

        :raises NodeUnreachable: nothing is heard of it
        """

    def description(self) -> CellDescription:
        """Return what exists in the cell.

        :raises NodeUnreachable: nothing is heard of it
        """

    def follow(self, listener: Listener, after_seq: int | None = None, history: str = '') -> None:
        """Tell a listener everything from an event on, without gaps, across restarts of the node.

        Each call adds a listener. Nothing is told before the next `turn`.

        :param after_seq: last event that the listener knows; None: only what happens from now on
        :param history: that `after_seq` counts in; empty: that of now. If the cell has another
            one, `on_history` comes first and everything from its first event
        :raises NodeUnreachable: nothing is heard of the node
        """

    def turn(self, within_s: float) -> None:
        """Handle what comes within a time: here listeners are called.

        It returns early when it has told something. Nothing is raised while the node is away:
        then `silent_s` grows. A listener may close the door.

        :raises NodeUnreachable: the node is there, and says that it cannot read its journal
        """

    @property
    def silent_s(self) -> float:
        """For how long nothing was heard of the node, seconds.

        It says something once a second, whether anything happens or not. So a small number means
        that there are no news, and a number of some seconds that the node is away. It counts
        while somebody follows.
        """

    def events_after(self, seq: int, most: int = 0) -> EventPage:
        """Return events from the journal of the cell, as many as it gives at once.

        :param most: not more than so many; 0: as many as it gives
        :raises NodeUnreachable: it does not answer, or cannot read its journal
        """

    def queue(self, after: str = '', most: int = 0) -> QueuePage:
        """Return jobs of the queue in their order.

        :param after: the last job that is known; empty: from the first
        :raises CommandRefused: that job is not in the queue (any more)
        :raises NodeUnreachable: it does not answer
        """

    def moment(self) -> Moment:
        """Return the state of now, for a virtual run that begins with it.

        Of a long queue it has the first jobs (`model.limits`).

        :raises NodeUnreachable: it does not answer, or cannot tell its state at this moment
        """

    def ask(self, asked: Asked) -> Answer:
        """Ask something of the cell and wait for its answer, which is on record by then.

        :raises NodeUnreachable: it does not answer; then nobody knows whether it was done
        """

    def close(self) -> None:
        """Leave; the cell does not notice."""


class Past(Protocol):
    """Any past moment of a cell, from its journal."""

    def status_at(self, seq: int) -> CellStatus:
        """Return how the cell stood after an event, with the reasons why it waited.

        :raises NotKept: that event is not in the journal, or what came before it
        """


class ExpectedJob(NamedTuple):
    """When a job is expected to end."""

    job: str
    ends_s: float | None
    """Seconds from the moment that was asked about; None: not at all, as things stand."""


class Consequence(NamedTuple):
    """What some requests would do."""

    before: Sequence[ExpectedJob]
    after: Sequence[ExpectedJob]
    refusals: Sequence[str]
    """Of requests that would be refused, in their order; empty: none."""


class WhatIf(Protocol):
    """What would become of jobs after some requests, by the engine that runs the cell."""

    def ask(self, requests: Sequence[Asked]) -> Consequence:
        """Work out when jobs end as things are, and when after these requests.

        :raises NotKept: the state to start from cannot be had
        """
