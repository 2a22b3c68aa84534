"""Services that change nothing: events that a client has missed, the jobs, the state."""

from __future__ import annotations

import json
from collections.abc import Iterator
from functools import partial
from typing import Any

from bt_orchestrator_interfaces.msg import Event as EventMessage
from bt_orchestrator_interfaces.srv import GetEvents, GetState, ListJobs, QueueList
from rclpy.node import Node

from bt_orchestrator.base.errors import CommandRefused, DamagedRecord, OrchestratorError
from bt_orchestrator.engine.runtime import listed_jobs
from bt_orchestrator.engine.runtime.observed_durations import ObservedDurations
from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.engine.runtime.overview import Overview
from bt_orchestrator.engine.runtime.writers import Readings
from bt_orchestrator.model.codec import json_of, to_plain, to_text
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.keeping.snapshot import nearest, state_to_text
from bt_orchestrator.model.limits import EVENTS_BYTES, EVENTS_PAGE, QUEUE_PAGE, fitting
from bt_orchestrator.model.state import CellState, JobState
from bt_orchestrator.ports import EventStore
from bt_orchestrator.ros.clock import to_time
from bt_orchestrator.ros.services.patient_service import serve
from bt_orchestrator.ros.types.status_messages import job_message, listed_message


class EventsService:
    """Answers from the journal; so whatever it tells is durable.

    The journal is read in another thread, since a database may take long.
    """

    def __init__(
        self, node: Node, orchestrator: Orchestrator, store: EventStore, readings: Readings
    ) -> None:
        self._orchestrator = orchestrator
        self._store = store
        self._readings = readings
        self._log = node.get_logger()
        serve(node, GetEvents, 'get_events', self._answer)

    async def _answer(self, request: Any, response: Any) -> None:
        most = min(request.most or EVENTS_PAGE, EVENTS_PAGE)
        last = self._orchestrator.kept_seq
        read = partial(self._readable, request.after_seq, most, last)
        try:
            # What was removed or is damaged cannot be told; a client sees that from first_seq.
            response.first_seq, response.events = await self._readings.result_of(read)
        except OrchestratorError as error:
            response.message = str(error)
            return
        response.history = self._store.history
        response.last_seq = last
        response.accepted = True

    def _readable(self, after: int, most: int, last: int) -> tuple[int, list[Any]]:
        """Return the first event that can be had, and messages of events without gaps.

        :param last: the last event that is durable
        """
        first = self._store.first_seq()
        while True:
            messages: list[Any] = []
            try:
                if after < last:
                    messages.extend(self._messages(after, min(most, last - after)))
            except DamagedRecord as damage:
                self._log.warning(f'{damage}; clients that ask for it get the events after it')
                if not messages:
                    after, first = damage.last, damage.last + 1
                    continue
            return first, messages

    def _messages(self, after: int, most: int) -> Iterator[Any]:
        """Yield as many events as one answer may tell."""
        events = self._store.read(after, most)
        messages = (event_message(event, self._store.history) for event in events)
        return fitting(messages, EVENTS_BYTES, lambda message: len(message.record))


# An event as a message (bt_orchestrator_interfaces/msg/Event).


def event_message(event: Event, history: str) -> EventMessage:
    """Build the message of a durable event.

    :param history: name of its journal
    """
    return EventMessage(
        seq=event.seq,
        history=history,
        stamp=to_time(event.time),
        event=event.event,
        record=to_text(event),
    )


# `~/queue/list` and `~/list_jobs`: the jobs of the cell, page by page.


def serve_lists(node: Node, overview: Overview, state: CellState) -> None:
    """Offer both services."""

    async def answer_queue(request: Any, response: Any) -> None:
        list_queue(state, overview, request, response)

    async def answer_jobs(request: Any, response: Any) -> None:
        list_jobs(state, overview, request, response)

    serve(node, QueueList, 'queue/list', answer_queue)
    serve(node, ListJobs, 'list_jobs', answer_jobs)


def list_queue(state: CellState, overview: Overview, request: Any, response: Any) -> None:
    """Fill a response with jobs of the queue (bt_orchestrator_interfaces/srv/QueueList)."""
    place = state.jobs.place(request.after)
    if request.after and not place:
        response.message = f'{request.after} is not in the queue'
        return
    most = min(request.most or QUEUE_PAGE, QUEUE_PAGE)
    response.accepted, response.queued = True, state.jobs.waiting
    entries = [(job, _details(job)) for job in state.jobs.queue(place + 1, most)]
    entries = list(fitting(entries, listed_jobs.PAGE_BYTES, lambda entry: len(entry[1])))
    response.jobs = [job_message(overview.job(job)) for job, _ in entries]
    response.details = [details for _, details in entries]


def list_jobs(state: CellState, overview: Overview, request: Any, response: Any) -> None:
    """Fill a response with listed jobs (bt_orchestrator_interfaces/srv/ListJobs)."""
    try:
        if request.job:
            jobs = [listed_jobs.told_of(listed_jobs.find(state, request.job), overview)]
        else:
            jobs = listed_jobs.page(state, overview, request.after, request.most)
    except CommandRefused as why:
        response.message = str(why)
        return
    response.accepted, response.jobs = True, list(map(listed_message, jobs))


def _details(job: JobState) -> str:
    details = job.job.terms.details
    return json_of(details) if details else ''


# `~/get_state`: the current state, for predictions by a client.


class StateService:
    """Answers with what is durable; a state that waits for the disk is refused."""

    def __init__(
        self, node: Node, orchestrator: Orchestrator, durations: ObservedDurations
    ) -> None:
        self._node = node
        self._orchestrator = orchestrator
        self._durations = durations
        serve(node, GetState, 'get_state', self._answer)

    async def _answer(self, _: Any, response: Any) -> None:
        if self._orchestrator.awaits_disk:
            response.message = f'not at this moment: {self._orchestrator.disk_wait}'
            return
        state = self._orchestrator.state
        response.cell = json.dumps(to_plain(state.cell))
        response.state = state_to_text(nearest(state, with_ids=True))
        response.observed = json.dumps(self._durations.seconds())
        response.now = self._node.get_clock().now().nanoseconds / 1e9
        response.history, response.seq = state.history, state.seq
        response.accepted = True
