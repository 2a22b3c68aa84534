"""`~/submit_order` and `~/queue/...`: what can be asked of the queue and of its jobs."""

from __future__ import annotations

from typing import Any

from bt_orchestrator_interfaces.srv import (
    ListJobs,
    QueueAdd,
    QueueCommand,
    QueueList,
    QueueMove,
    QueueStopAfter,
    QueueUpdate,
    SubmitOrder,
)
from rclpy.node import Node

from bt_orchestrator.asking.handler import RequestHandler
from bt_orchestrator.errors import CommandRefused
from bt_orchestrator.model.codec import json_of
from bt_orchestrator.model.limits import QUEUE_PAGE, fitting
from bt_orchestrator.model.requests import MOVE, About
from bt_orchestrator.model.state import CellState, JobState
from bt_orchestrator.model.wish import STOP_AFTER
from bt_orchestrator.ros.services.order_requests import AskedOrders
from bt_orchestrator.ros.services.senders import Senders
from bt_orchestrator.ros.services.serving import serve, tell
from bt_orchestrator.ros.types.order_messages import asked_change, asked_order
from bt_orchestrator.ros.types.status_messages import (
    job_message,
    listed_message,
    order_answer_message,
)
from bt_orchestrator.runtime import listed_jobs
from bt_orchestrator.runtime.overview import Overview


class QueueServices:
    """Requests become commands in the one inbox of the cell; nothing is decided here."""

    def __init__(
        self,
        node: Node,
        handler: RequestHandler,
        senders: Senders,
        overview: Overview,
        state: CellState,
    ) -> None:
        self._handler = handler
        self._senders = senders
        self._overview = overview
        self._state = state
        serve(node, SubmitOrder, 'submit_order', self._submit)
        serve(node, QueueAdd, 'queue/add', self._add)
        serve(node, QueueMove, 'queue/move', self._move)
        serve(node, QueueUpdate, 'queue/update', self._update)
        serve(node, QueueCommand, 'queue/command', self._command)
        serve(node, QueueStopAfter, 'queue/stop_after', self._stop_after)
        serve(node, QueueList, 'queue/list', self._list)
        serve(node, ListJobs, 'list_jobs', self._list_jobs)

    async def _submit(self, request: Any, response: Any) -> None:
        answer = await self._handler.add(
            [asked_order(request)], self._senders.by(request), None, held=False
        )
        tell(response, answer)
        for of_order in answer.orders:
            response.job, response.findings = of_order.job, of_order.findings

    async def _add(self, request: Any, response: Any) -> None:
        orders, position = AskedOrders(request.orders), request.position or None
        answer = await self._handler.add(
            orders, self._senders.by(request), position, held=request.held
        )
        tell(response, answer)
        response.answers = list(map(order_answer_message, answer.orders))

    async def _update(self, request: Any, response: Any) -> None:
        answer = await self._handler.update(
            request.job, asked_change(request), self._senders.by(request)
        )
        tell(response, answer)
        for of_order in answer.orders:
            response.findings = of_order.findings

    async def _move(self, request: Any, response: Any) -> None:
        by = self._senders.by(request)
        answer = await self._handler.give(
            About.JOB, MOVE.word, by, job=request.job, position=request.position
        )
        tell(response, answer)

    async def _command(self, request: Any, response: Any) -> None:
        by = self._senders.by(request)
        answer = await self._handler.give(
            About.JOB, request.command, by, job=request.job, order=request.order
        )
        tell(response, answer)
        for of_order in answer.orders:
            response.findings = of_order.findings

    async def _stop_after(self, request: Any, response: Any) -> None:
        word = STOP_AFTER + request.after
        tell(response, await self._handler.give(About.CELL, word, self._senders.by(request)))

    async def _list_jobs(self, request: Any, response: Any) -> None:
        list_jobs(self._state, self._overview, request, response)

    async def _list(self, request: Any, response: Any) -> None:
        list_queue(self._state, self._overview, request, response)


def list_queue(state: CellState, overview: Overview, request: Any, response: Any) -> None:
    """Fill a response with jobs of the queue (bt_orchestrator_interfaces/srv/QueueList)."""
    place = state.jobs.place(request.after)
    if request.after and not place:
        response.message = f'{request.after} is not in the queue'
        return
    most = min(request.most or QUEUE_PAGE, QUEUE_PAGE)
    response.accepted, response.queued = True, state.jobs.waiting
    told = [(job, _details(job)) for job in state.jobs.queue(place + 1, most)]
    told = list(fitting(told, listed_jobs.PAGE_BYTES, lambda one: len(one[1])))
    response.jobs = [job_message(overview.job(job)) for job, _ in told]
    response.details = [details for _, details in told]


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
