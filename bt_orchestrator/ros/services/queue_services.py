"""`~/submit_order` and `~/queue/...`: what can be asked of the queue and of its jobs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from bt_orchestrator_interfaces.msg import OrderAnswer
from bt_orchestrator_interfaces.srv import (
    QueueAdd,
    QueueCommand,
    QueueList,
    QueueMove,
    QueueStopAfter,
    QueueUpdate,
    SubmitOrder,
)
from rclpy.node import Node

from bt_orchestrator.errors import Refused, counted
from bt_orchestrator.model.by import By
from bt_orchestrator.model.codec import json_of
from bt_orchestrator.model.commands import Answer, RefusedRequest
from bt_orchestrator.model.jobs.job_commands import (
    AddJobs,
    ControlJob,
    MoveJob,
    RunNext,
    StopAfter,
    UpdateJob,
)
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.limits import QUEUE_PAGE, fitting, listed
from bt_orchestrator.model.state import CellState, JobState
from bt_orchestrator.ros.services.order_process import NotRead
from bt_orchestrator.ros.services.order_reader import OrderReader
from bt_orchestrator.ros.services.order_requests import (
    Told,
    asked_change,
    asked_orders,
    name_of,
    refused_orders,
    total,
)
from bt_orchestrator.ros.services.serving import by, serve, tell
from bt_orchestrator.ros.types.job_messages import job_message
from bt_orchestrator.runtime.command_record import ADD, UPDATE
from bt_orchestrator.runtime.job_queue import standing
from bt_orchestrator.runtime.orchestrator import Orchestrator
from bt_orchestrator.runtime.orders import FITS
from bt_orchestrator.runtime.overview import Overview
from bt_orchestrator.script.orders.desk import AskedOrder, ChangedJob, Reading

NEXT = 'next'
"""The one command to a job that is about its place, and not about its state."""


DETAILS_TOLD_BYTES = 1_000_000
"""Most details of jobs in one answer; where they are longer it has fewer jobs."""


class QueueServices:
    """Requests become commands in the one inbox of the cell; nothing is decided here."""

    def __init__(
        self, node: Node, orchestrator: Orchestrator, overview: Overview, orders: OrderReader
    ) -> None:
        self._orchestrator = orchestrator
        self._overview = overview
        self._orders = orders
        serve(node, SubmitOrder, 'submit_order', self._submit)
        serve(node, QueueAdd, 'queue/add', self._add)
        serve(node, QueueMove, 'queue/move', self._move)
        serve(node, QueueUpdate, 'queue/update', self._update)
        serve(node, QueueCommand, 'queue/command', self._command)
        serve(node, QueueStopAfter, 'queue/stop_after', self._stop_after)
        serve(node, QueueList, 'queue/list', self._list)

    async def _submit(self, request: Any, response: Any) -> None:
        answer, answers = await self._queue([request], None, held=False, by=by(request))
        tell(response, answer)
        for of_order in answers:
            response.job, response.findings = of_order.job, of_order.findings

    async def _add(self, request: Any, response: Any) -> None:
        if not request.orders:
            tell(response, await self._refuse(ADD, request, 'name at least one order'))
            return
        position = request.position or None
        answer, response.answers = await self._queue(
            request.orders, position, held=request.held, by=by(request)
        )
        tell(response, answer)

    async def _queue(
        self, orders: Sequence[Any], position: int | None, *, held: bool, by: By
    ) -> tuple[Answer, list[OrderAnswer]]:
        try:
            async with self._orders.read(asked_orders(orders)) as reading:
                return await self._queue_read(orders, reading, position, held=held, by=by)
        except NotRead as why:
            return await self._orchestrator.carry_out(RefusedRequest(ADD, by, str(why))), []

    async def _queue_read(
        self,
        orders: Sequence[Any],
        reading: Reading,
        position: int | None,
        *,
        held: bool,
        by: By,
    ) -> tuple[Answer, list[OrderAnswer]]:
        read = reading.read
        jobs = tuple(job for job in read if isinstance(job, Job))
        if len(jobs) < len(read):
            await self._orchestrator.carry_out(refused_orders(orders, read, by))
            answer = Answer(
                accepted=False, message=f'refused with {counted(total(read), "finding")}'
            )
            told = Told()
            return answer, [
                _of_reading(order, one, told) for order, one in zip(orders, read, strict=True)
            ]
        command = AddJobs(jobs, by, position, held, reading.sharing)
        answer = await self._orchestrator.carry_out(command)
        if answer.accepted:
            message = '; '.join(['queued', *standing(self._orchestrator.state)])
            return answer, [OrderAnswer(job=job.id, message=message) for job in jobs]
        each = answer.each or (answer.message,) * len(jobs)
        return answer, [OrderAnswer(message=message) for message in each]

    async def _move(self, request: Any, response: Any) -> None:
        command = MoveJob(request.job, request.position, by(request))
        tell(response, await self._orchestrator.carry_out(command))

    async def _update(self, request: Any, response: Any) -> None:
        try:
            wish = asked_change(request)
            async with self._orders.read(lambda: self._change(request.job, wish)) as reading:
                await self._update_read(request, response, reading)
        except NotRead as why:
            tell(response, await self._refuse(UPDATE, request, str(why), request.job))

    async def _update_read(self, request: Any, response: Any, reading: Reading) -> None:
        (read,) = reading.read
        if isinstance(read, Refused):
            await self._refuse(UPDATE, request, read.in_short, request.job)
            response.message, response.findings = read.count, Told().of(read)
            return
        command = UpdateJob(read, by(request), reading.sharing)
        tell(response, await self._orchestrator.carry_out(command))

    def _change(self, name: str, wish: AskedOrder) -> ChangedJob:
        """Return what is to be made of a job as it is now."""
        state = self._orchestrator.state
        now = state.jobs.get(name)
        if now is None:
            there = listed(state.jobs.queued_names, 'nothing')
            raise NotRead(f'{name} is not there; in the queue: {there}')
        job = now.job
        return ChangedJob(name, now.digest, job.quantity, job.params, wish, job.terms)

    async def _refuse(self, verb: str, request: Any, message: str, *jobs: str) -> Answer:
        """Put a request on record that cannot be made a command."""
        return await self._orchestrator.carry_out(RefusedRequest(verb, by(request), message, jobs))

    async def _command(self, request: Any, response: Any) -> None:
        command = (
            RunNext(request.job, by(request))
            if request.command == NEXT
            else ControlJob(request.command, request.job, by(request))
        )
        tell(response, await self._orchestrator.carry_out(command))

    async def _stop_after(self, request: Any, response: Any) -> None:
        tell(response, await self._orchestrator.carry_out(StopAfter(request.after, by(request))))

    async def _list(self, request: Any, response: Any) -> None:
        list_queue(self._orchestrator.state, self._overview, request, response)


def list_queue(state: CellState, overview: Overview, request: Any, response: Any) -> None:
    """Fill a response with jobs of the queue (bt_orchestrator_interfaces/srv/QueueList)."""
    place = state.jobs.place(request.after)
    if request.after and not place:
        response.message = f'{request.after} is not in the queue'
        return
    most = min(request.most or QUEUE_PAGE, QUEUE_PAGE)
    response.accepted, response.queued = True, state.jobs.waiting
    told = [(job, _details(job)) for job in state.jobs.queue(place + 1, most)]
    told = list(fitting(told, DETAILS_TOLD_BYTES, lambda one: len(one[1])))
    response.jobs = [job_message(overview.job(job)) for job, _ in told]
    response.details = [details for _, details in told]


def _details(job: JobState) -> str:
    details = job.job.terms.details
    return json_of(details) if details else ''


def _of_reading(order: Any, read: Job | Refused, told: Told) -> OrderAnswer:
    if isinstance(read, Job):
        return OrderAnswer(message=f'{read.id} {FITS}')
    return OrderAnswer(message=f'{name_of(order)} is {read.count}', findings=told.of(read))
