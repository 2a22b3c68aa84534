"""The door to a cell over topics and services."""

from __future__ import annotations

import json
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from bt_orchestrator_interfaces import srv
from bt_orchestrator_interfaces.srv import GetEvents, GetState, ListJobs, QueueList

from bt_orchestrator.base.errors import CommandRefused, NodeUnreachable
from bt_orchestrator.model.branch import Branch
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.codec import from_plain, from_record
from bt_orchestrator.model.commands import Answer
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.requests import Asked
from bt_orchestrator.model.status import CellDescription, CellStatus, ListedJob
from bt_orchestrator.model.uptime import Uptime
from bt_orchestrator.ports import EventPage, Listener, Moment, QueuePage, Watch
from bt_orchestrator.ports.following import Follower
from bt_orchestrator.ros.link.client import EventFetches, NodeClient
from bt_orchestrator.ros.link.requests import Call, answer_of, call_of, signed_call
from bt_orchestrator.ros.types.status_messages import job_status, listed_job
from bt_orchestrator.script.users.keys import Place, SigningKey

if TYPE_CHECKING:
    from bt_orchestrator.ros.link.inspection_streams import InspectionStream

MOST_AT_ONCE = 100
"""Messages that are handled in one turn: whoever turns has other things to do."""


class RosLink:
    """Sees one tree node. Implements `ports.CellLink`.

    A context: leaving it tells on stderr if several nodes have answered. It listens to the topics
    from the first `follow` on.
    """

    def __init__(
        self,
        node: str,
        timeout_s: float,
        meanwhile: Callable[[], object] | None = None,
        answer_s: float | None = None,
        key: SigningKey | None = None,
    ) -> None:
        """Join the ROS graph.

        :param node: the tree node's full name, for instance /bt_orchestrator
        :param timeout_s: longest time to wait for the node and for each of its answers
        :param meanwhile: called again and again while it waits; what it raises ends the waiting
        :param answer_s: longest time to wait for an answer, if it is longer
        :param key: signs all requests; None: they go unsigned
        """
        self._key = key
        self._client = NodeClient(node, timeout_s, meanwhile, answer_s)
        self._client.__enter__()
        self._fetches: EventFetches | None = None
        """None: there is no follower."""
        self._followers: list[tuple[Listener, Follower]] = []
        self._streams: list[InspectionStream] = []
        self._heard: deque[Any] = deque()
        self._status: CellStatus | None = None
        """Has come and was not handed on."""
        self._heard_at = time.monotonic()
        self._is_closed = False

    def __enter__(self) -> RosLink:
        return self

    def __exit__(self, kind: object, *exception: object) -> None:
        if not self._is_closed:
            self._is_closed = True
            self._followers.clear()
            self._client.__exit__(kind, *exception)

    def close(self) -> None:
        """Leave the ROS graph."""
        self.__exit__(None)

    @property
    def name(self) -> str:
        """Full name of the tree node."""
        return self._client.name

    # --- what is so -------------------------------------------------------------------------

    def status(self) -> CellStatus:
        """Return the latched status."""
        status = self._client.status()
        self._note()
        return status

    def description(self) -> CellDescription:
        """Return what exists in the cell."""
        return self._client.description()

    def events_after(self, seq: int, most: int = 0) -> EventPage:
        """Return events from the journal of the node."""
        request = GetEvents.Request(after_seq=seq, most=most)
        return self._page(self._client.call(GetEvents, 'get_events', request))

    def queue(self, after: str = '', most: int = 0) -> QueuePage:
        """Return jobs of the queue.

        :raises CommandRefused: the job to begin behind is not in the queue (any more)
        """
        request = QueueList.Request(after=after, most=most)
        answer = self._client.call(QueueList, 'queue/list', request)
        if not answer.accepted:
            raise CommandRefused(answer.message)
        return QueuePage(tuple(map(job_status, answer.jobs)), answer.queued)

    def jobs(self, after: str = '', most: int = 0) -> Sequence[ListedJob]:
        """Return listed jobs.

        :raises CommandRefused: the job to begin behind is not listed (any more)
        """
        return self._listed(ListJobs.Request(after=after, most=most))

    def job(self, name: str) -> ListedJob:
        """Return a listed job.

        :raises CommandRefused: it is not listed (any more)
        """
        return self._listed(ListJobs.Request(job=name))[0]

    def _listed(self, request: ListJobs.Request) -> Sequence[ListedJob]:
        answer = self._client.call(ListJobs, 'list_jobs', request)
        if not answer.accepted:
            raise CommandRefused(answer.message)
        return tuple(map(listed_job, answer.jobs))

    def moment(self) -> Moment:
        """Return the state of now."""
        answer = self._client.call(GetState, 'get_state', GetState.Request())
        if not answer.accepted:
            raise NodeUnreachable(f'{self.name} cannot tell its state: {answer.message}')
        cell = from_plain(Cell, json.loads(answer.cell))
        return Moment(cell, json.loads(answer.state), answer.now, json.loads(answer.observed))

    # --- asking -----------------------------------------------------------------------------

    def ask(self, asked: Asked) -> Answer:
        """Call the service for a request."""
        try:
            if self._key is not None:
                call = Call(srv.SignedRequest, 'signed_request', partial(self._signed, asked))
            else:
                call = call_of(asked)
            return answer_of(self._client.call(*call))
        except CommandRefused as why:
            return Answer(accepted=False, message=str(why))

    def _signed(self, asked: Asked, status: Any) -> Any:
        assert self._key is not None
        place = Place(self.name, status.history, Uptime(status.boot, status.uptime))
        return signed_call(asked, self._key, place)

    # --- following --------------------------------------------------------------------------

    def follow(self, listener: Listener, after_seq: int | None = None, history: str = '') -> None:
        """Tell a listener what happens, in `turn`."""
        if self._fetches is None:
            fetches = EventFetches(self._client)
            self._client.on_event(self._on_event)
            self._client.on_status(self._on_status)
            self._fetches = fetches
        now = self.status()
        if after_seq is None:
            # The status tells of an event a moment after it has happened, the journal at once.
            page = self.events_after(now.seq, 1)
            after_seq, history = page.last_seq, page.history
        follower = Follower(listener, history or now.history, after_seq)
        self._followers.append((listener, follower))
        self._status = now

    def turn(self, within_s: float) -> None:
        """Handle what comes within a time, not waiting for more once something is there."""
        self._streams = [stream for stream in self._streams if not stream.is_closed]
        for stream in self._streams:
            stream.look()
        until = time.monotonic() + within_s
        while not self._has_news and (left_s := until - time.monotonic()) > 0:
            self._client.spin(left_s)
        handled, count = -1, len(self._heard)
        while handled < count < MOST_AT_ONCE:
            self._client.spin(0.0)
            handled, count = count, len(self._heard)
        self._tell()

    def watch_tree(self, hear: Callable[[Branch], None]) -> Watch:
        """Tell of the behaviour tree, whenever it has changed, in `turn`."""
        from bt_orchestrator.ros.link.inspection_streams import tree_stream

        stream = tree_stream(self._client.node, self.name, hear)
        self._streams.append(stream)
        return stream

    def watch_blackboard(self, hear: Callable[[Mapping[str, str]], None]) -> None:
        """Tell of the variables on the blackboard, whenever one has changed, in `turn`."""
        from bt_orchestrator.ros.link.inspection_streams import blackboard_stream

        self._streams.append(blackboard_stream(self._client.node, self.name, hear))

    @property
    def silent_s(self) -> float:
        """For how long nothing was heard of the node, seconds."""
        return time.monotonic() - self._heard_at

    @property
    def _has_news(self) -> bool:
        is_fetched = self._fetches is not None and self._fetches.has_any
        return bool(self._heard) or self._status is not None or is_fetched

    def _on_event(self, message: Any) -> None:
        self._heard.append(message)
        self._note()

    def _on_status(self, status: CellStatus) -> None:
        self._status = status
        self._note()

    def _note(self) -> None:
        self._heard_at = time.monotonic()

    def _tell(self) -> None:
        """Hand on what is there; any listener may close the door."""
        heard = [(message.history, event_of(message)) for message in self._heard]
        self._heard.clear()
        status, self._status = self._status, None
        for listener, follower in list(self._followers):
            for history, event in heard:
                if not self._is_closed:
                    follower.heard(history, event)
            if status is not None and not self._is_closed:
                follower.told(status.history, status.seq)
            if not self._is_closed:
                self._fetch(follower)
            if status is not None and not self._is_closed:
                listener.on_status(status)

    def _fetch(self, follower: Follower) -> None:
        """Hand on what was fetched for somebody, and fetch what is missing then."""
        assert self._fetches is not None
        fetched = self._fetches.take(follower)
        if fetched is not None:
            follower.fetched(self._page(fetched))
        elif self._fetches.is_given_up(follower):
            follower.not_fetched()
        after = None if self._is_closed else follower.next_fetch()
        if after is not None:
            self._fetches.begin(follower, after)

    def _page(self, answer: Any) -> EventPage:
        if not answer.accepted:
            raise NodeUnreachable(f'{self.name} cannot tell its events: {answer.message}')
        events = tuple(map(event_of, answer.events))
        return EventPage(answer.history, events, answer.first_seq, answer.last_seq)


def event_of(message: Any) -> Event:
    """Return the event of a message (bt_orchestrator_interfaces/msg/Event).

    :raises NodeUnreachable: it is none that this program knows
    """
    try:
        return from_record(json.loads(message.record))
    except (KeyError, TypeError, ValueError) as error:
        raise NodeUnreachable(
            f'event {message.seq} ({message.event}) cannot be read ({error!r}); is the tree node '
            'of another version than this program?'
        ) from error
