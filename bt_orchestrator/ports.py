"""The ports: what the orchestrator needs from outside, independent of the implementation.

Every implementation of a port passes the contract tests of that port (test/contract).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import Any, NamedTuple, Protocol, TypeVar

from bt_orchestrator.errors import Refused
from bt_orchestrator.model.action_type import ActionType
from bt_orchestrator.model.branch import Branch
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.goal import GoalEnd, GoalRequest, SeenContest, StateReading
from bt_orchestrator.model.jobs.job_record import JobRecord
from bt_orchestrator.model.jobs.order import RecipeChoice
from bt_orchestrator.model.records import Extent, JobPlace, Page, Summaries, Wanted
from bt_orchestrator.model.requests import Asked
from bt_orchestrator.model.status import CellDescription, CellStatus, JobStatus, ListedJob
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
        """True once the server accepted the goal."""

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
"""News of a gateway."""


class Servers(Protocol):
    """What is known of the action servers without a request to them."""

    def available(self, component: str) -> bool:
        """Tell whether the component's action server was seen at the last check; for show."""

    def rivals(self, component: str) -> Sequence[str]:
        """Return the nodes that serve a component's action, if several are known now.

        Nothing is sent then: a request waits as if there were no server, and `drain` reports it
        (`SeenContest`). An answer "unknown goal" from any of them is ignored.
        """

    def server(self, component: str) -> str | None:
        """Return an id of the instance of the component's server that was seen last.

        A restarted server has another id and does not know the goals of the earlier instance. The
        id may be out of date; then only the proof that needs it fails (semantics 9.2). None: no
        server was seen, or several with one name.
        """


class ActionGateway(Servers, Protocol):
    """The only access to the robots. All calls come from the tick thread."""

    def listen(self, wake: Callable[[], None]) -> None:
        """Set the function that is called whenever `drain` has an end or a state reading.

        An acceptance alone does not call it: nothing follows from it.
        """

    def send(self, request: GoalRequest) -> Goal:
        """Send one goal; returns at once, whatever the server does.

        A request without a server waits for one for the gateway's server timeout, then it ends
        UNAVAILABLE.
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
    """Time as a port: no other code reads a wall clock or sleeps."""

    def now(self) -> float:
        """Seconds: since the epoch in a real run, from 0 in a virtual one.

        For records, and for the start of an order. It may be set forward or back, so no deadline
        uses it.
        """

    def steady(self) -> float:
        """Seconds of a monotonic clock, from an arbitrary start in this process."""

    def call_at(self, time: float, callback: Callable[[], None]) -> Timer:
        """Call back once, in the tick thread, when `steady()` has reached `time`."""

    def uptime(self) -> Uptime | None:
        """How long the machine has been up, comparable between processes.

        None: not available, or the clock does not run in real time.
        """


class Snapshot(NamedTuple):
    """The state after an event."""

    seq: int
    stamp: str
    """Program and cell that it was written by and for."""
    state: str
    """As JSON."""


class EventStore(Protocol):
    """The journal: the only durable truth."""

    @property
    def history(self) -> str:
        """Return the id of the history of the events: random, unique to this journal.

        Event numbers are valid only within one history.
        """

    @property
    def is_restored(self) -> bool:
        """Tell whether this history continues a copy of another one (semantics 9.2)."""

    def missing(self, after: int) -> str:
        """Say what was written after an event and is lost; empty: nothing.

        :raises JournalUnusable: it cannot be read
        """

    def go_on_after(self, seq: int) -> None:
        """Begin a new history after an event, with the next `append`.

        Others have seen the lost events under their numbers, which new events now reuse.
        """

    def append(self, events: Sequence[Event]) -> None:
        """Make the events durable, all or none.

        :param events: one or more, with the next numbers
        :raises JournalFailed: none of them is durable
        """

    def read(self, after: int = 0, most: int = -1) -> Iterable[Event]:
        """Return the events with a seq greater than `after`, oldest first.

        Errors are raised when the iteration reaches them.

        :param most: so many at most; -1: all
        :raises DamagedRecord: the next one cannot be read; those before it are intact
        :raises JournalUnusable: nothing more can be read
        """

    def first_seq(self) -> int:
        """Return the seq of the first event that is kept; if none is, of the next one.

        :raises JournalUnusable: it cannot be read
        """

    def snapshots(self) -> Iterable[Snapshot]:
        """Return states to start from, newest first. Each is a cache and may be ignored."""

    def beginning(self) -> Snapshot | None:
        """Return the state that replay begins with; None: it begins with the first event.

        :raises JournalUnusable: it is damaged, or cannot be read
        """


class Journal(EventStore, Protocol):
    """A journal that outlives its process, and is kept short for the next start."""

    def save(self, snapshot: Snapshot, ended: Sequence[JobRecord] = ()) -> None:
        """Store a state to start from, and the summaries of jobs that ended.

        :raises JournalFailed: neither is stored
        """

    def first_needed(self, live: Collection[str], keep_jobs: int) -> int:
        """Return the seq of the first event of any live job, or of the last `keep_jobs` others.

        0: there are no more jobs than that.

        :raises JournalFailed: it cannot be read
        """

    def begin_with(self, snapshot: Snapshot) -> None:
        """Make replay begin with a state: events up to it may be removed.

        :raises JournalFailed: nothing has changed
        """

    def remove_batch(self, before: int) -> bool:
        """Remove some of the first events before a seq, none that replay needs.

        :return: whether there are more
        :raises JournalFailed: none were removed
        """

    def close(self) -> None:
        """Close it and release its lock."""


class Records(Protocol):
    """A journal as its readers see it, with or without a running writer.

    Reading changes nothing. Each answer is consistent and quick, so the writer never has to wait.
    Damaged or missing records are reported in the answer, never silently left out. Items are a
    fold of the records of their job (`report.reading`). One thread at a time.
    """

    def extent(self) -> Extent:
        """Return the range of events in it.

        :raises JournalUnusable: it cannot be read
        """

    def page(self, wanted: Wanted, most: int = 1000) -> Page:
        """Return the next wanted records; continue with `Page.rest`.

        A page that is not the last may have fewer than `most` records, or none: it also ends after
        a limit of records read.

        :raises JournalUnusable: it cannot be read
        """

    def summaries(
        self, after: JobPlace | None = None, most: int = 1000, *, newest_first: bool = False
    ) -> Summaries:
        """Return the summaries of jobs that ended, with or without events, in queue order.

        :param after: where to continue (`Summaries.rest`); None: from the first
        :raises JournalUnusable: it cannot be read
        """

    def state_before(self, seq: int) -> Snapshot | None:
        """Return a stored state from which few events lead to the state after an event.

        None: there is none; then replay begins with the first event, if that is kept.

        :raises JournalUnusable: it cannot be read
        """

    def close(self) -> None:
        """Close it."""


class Writing(Protocol[_Result_co]):
    """A write in progress."""

    def has_ended(self, within_s: float = 0.0) -> bool:
        """Tell whether it has ended, successfully or not; wait at most `within_s` for that."""

    def result(self) -> _Result_co:
        """Return its result once it has ended, or raise its error."""


class Writer(Protocol):
    """Carries out disk writes one after another, in order, so that callers need not wait."""

    def begin(self, write: Callable[[], _Result]) -> Writing[_Result]:
        """Begin a write.

        A caller that saw `has_ended` return False is woken when it has ended.

        :param write: uses the journal, and nothing that changes meanwhile
        """


class EventSink(Protocol):
    """An output of the event stream; one that fails never stops the cell."""

    def publish(self, events: Sequence[Event]) -> None:
        """Publish durable events, oldest first."""


class Foresight(Protocol):
    """Forecasts when jobs end, outside the tick thread."""

    def ask(self, state: str, observed_s: Mapping[str, Mapping[str, float]], now_s: float) -> None:
        """Request a forecast from a state; returns at once. A later request replaces it.

        :param state: of `model.keeping.snapshot`, as JSON
        :param observed_s: task durations in seconds, by component and task constant
        """

    @property
    def ends_s(self) -> Mapping[str, float]:
        """When each live job will end, by the last forecast; unknown ones are left out."""

    def close(self) -> None:
        """Stop working."""


class MadeScript(NamedTuple):
    """A script that was generated for an order by recipe."""

    name: str
    """As findings call it."""
    text: str


class Generating(Protocol):
    """Generates the scripts of orders by recipe, outside the tick thread."""

    async def make(
        self, choices: Sequence[RecipeChoice], without: frozenset[str]
    ) -> Sequence[MadeScript | Refused]:
        """Return the script of each, or why there is none. Only replies are awaited.

        :param without: components that are out of service
        :raises NotRead: says why nothing could be generated
        """

    def close(self) -> None:
        """Stop working."""


# --- the door: people and machines outside ------------------------------------------------------


class EventPage(NamedTuple):
    """Consecutive events of one history."""

    history: str
    events: Sequence[Event]
    """Oldest first; empty: there are no more yet."""
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
        """Look no more; harmless when it is closed. The listener is not called again."""


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


class Past(Protocol):
    """Any past state of a cell, from its journal."""

    def status_at(self, seq: int) -> CellStatus:
        """Return the status of the cell after an event, with the reasons why it waited.

        :raises NotKept: that event, or what came before it, is not in the journal
        """


class ExpectedJob(NamedTuple):
    """When a job is expected to end."""

    job: str
    ends_s: float | None
    """Seconds from the given moment; None: it does not end in the present situation."""


class Consequence(NamedTuple):
    """The effects of some requests."""

    before: Sequence[ExpectedJob]
    after: Sequence[ExpectedJob]
    refusals: Sequence[str]
    """Messages of the requests that would be refused, in order; empty: none."""


class WrongField(NamedTuple):
    """A mistake in one key of a work order."""

    field: str
    """For instance params.lot; empty: of the order as a whole."""
    what: str
    hint: str


class CheckedOrder(NamedTuple):
    """What would be said of a work order."""

    accepted: bool
    message: str
    """Why it would be refused, or not be checked; empty: it would be accepted."""
    wrong: Sequence[WrongField] = ()
    is_checked: bool = True
    """False: its script is not known here; the node may know it."""


class WhatIf(Protocol):
    """Predicts the effect of requests on jobs, with the engine that runs the cell."""

    def ask(self, requests: Sequence[Asked]) -> Consequence:
        """Predict when jobs end without and with these requests.

        :raises NotKept: the state to start from is not available
        """

    def check(self, order: Mapping[str, object]) -> CheckedOrder:
        """Tell whether an order, with the keys of an order file, would be queued.

        :raises NotKept: the state to start from is not available
        """


class Planning(Protocol):
    """Answers a planner's questions outside the asking process. One thread at a time."""

    def what_if(self, moment: Moment, requests: Sequence[Asked]) -> Consequence:
        """Predict when jobs end from a moment on, without and with these requests.

        :raises NotKept: nothing could be worked out
        """

    def check(self, moment: Moment, order: Mapping[str, object]) -> CheckedOrder:
        """Tell whether an order, with the keys of an order file, would be queued.

        :raises NotKept: nothing could be worked out
        """

    def close(self) -> None:
        """Stop working; may be called from any thread."""
