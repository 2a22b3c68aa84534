"""`~/submit_order` and `~/queue/...`: what can be asked of the queue and of its jobs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from bt_orchestrator_interfaces.msg import OrderAnswer
from bt_orchestrator_interfaces.srv import (
    QueueAdd,
    QueueCommand,
    QueueMove,
    QueueStopAfter,
    QueueUpdate,
    SubmitOrder,
)
from rclpy.node import Node

from bt_orchestrator.errors import Refused
from bt_orchestrator.model.by import By
from bt_orchestrator.model.commands import Answer, RefusedRequest
from bt_orchestrator.model.job_commands import (
    AddJobs,
    ControlJob,
    MoveJob,
    RunNext,
    StopAfter,
    UpdateJob,
)
from bt_orchestrator.model.limits import listed
from bt_orchestrator.model.order import Job
from bt_orchestrator.ros.order_reader import OrderReader, name_of, refused_orders
from bt_orchestrator.ros.serving import by, serve, tell
from bt_orchestrator.runtime.command_record import ADD, UPDATE
from bt_orchestrator.runtime.job_queue import standing
from bt_orchestrator.runtime.orchestrator import Orchestrator
from bt_orchestrator.runtime.orders import FITS

NEXT = 'next'
"""The one command to a job that is about its place, and not about its state."""


class QueueServices:
    """Requests become commands in the one inbox of the cell; nothing is decided here."""

    def __init__(self, node: Node, orchestrator: Orchestrator, orders: OrderReader) -> None:
        self._orchestrator = orchestrator
        self._orders = orders
        serve(node, SubmitOrder, 'submit_order', self._submit)
        serve(node, QueueAdd, 'queue/add', self._add)
        serve(node, QueueMove, 'queue/move', self._move)
        serve(node, QueueUpdate, 'queue/update', self._update)
        serve(node, QueueCommand, 'queue/command', self._command)
        serve(node, QueueStopAfter, 'queue/stop_after', self._stop_after)

    def _submit(self, request: Any, response: Any) -> None:
        answer, (of_order,) = self._queue([request], None, held=False, by=by(request))
        tell(response, answer)
        response.job, response.findings = of_order.job, of_order.findings

    def _add(self, request: Any, response: Any) -> None:
        if not request.orders:
            tell(response, self._refuse(ADD, request, 'name at least one order'))
            return
        position = request.position or None
        answer, response.answers = self._queue(
            request.orders, position, held=request.held, by=by(request)
        )
        tell(response, answer)

    def _queue(
        self, orders: Sequence[Any], position: int | None, *, held: bool, by: By
    ) -> tuple[Answer, list[OrderAnswer]]:
        read = self._orders.jobs(orders)
        jobs = tuple(job for job in read if isinstance(job, Job))
        if len(jobs) < len(read):
            self._orchestrator.ask(refused_orders(orders, read, by))
            count = sum(len(one.findings) for one in read if isinstance(one, Refused))
            answer = Answer(accepted=False, message=f'refused with {count} findings')
            return answer, [
                _of_reading(order, one) for order, one in zip(orders, read, strict=True)
            ]
        answer = self._orchestrator.ask(AddJobs(jobs, by, position, held))
        if answer.accepted:
            message = '; '.join(['queued', *standing(self._orchestrator.state)])
            return answer, [OrderAnswer(job=job.id, message=message) for job in jobs]
        each = answer.each or (answer.message,) * len(jobs)
        return answer, [OrderAnswer(message=message) for message in each]

    def _move(self, request: Any, response: Any) -> None:
        command = MoveJob(request.job, request.position, by(request))
        tell(response, self._orchestrator.ask(command))

    def _update(self, request: Any, response: Any) -> None:
        try:
            job = self._orders.changed(request.job, request)
        except Refused as refused:
            self._refuse(UPDATE, request, refused.in_short, request.job)
            response.message = refused.count
            response.findings = [str(finding) for finding in refused.findings]
            return
        if job is None:
            queue = self._orchestrator.state.queue
            there = listed((one.job.id for one in queue), 'nothing')
            message = f'{request.job} is not there; in the queue: {there}'
            tell(response, self._refuse(UPDATE, request, message, request.job))
            return
        tell(response, self._orchestrator.ask(UpdateJob(job, by(request))))

    def _refuse(self, verb: str, request: Any, message: str, *jobs: str) -> Answer:
        """Put a request on record that cannot be made a command."""
        return self._orchestrator.ask(RefusedRequest(verb, by(request), message, jobs))

    def _command(self, request: Any, response: Any) -> None:
        command = (
            RunNext(request.job, by(request))
            if request.command == NEXT
            else ControlJob(request.command, request.job, by(request))
        )
        tell(response, self._orchestrator.ask(command))

    def _stop_after(self, request: Any, response: Any) -> None:
        tell(response, self._orchestrator.ask(StopAfter(request.after, by(request))))


def _of_reading(order: Any, read: Job | Refused) -> OrderAnswer:
    if isinstance(read, Job):
        return OrderAnswer(message=f'{read.id} {FITS}')
    return OrderAnswer(
        message=f'{name_of(order)} is {read.count}',
        findings=[str(finding) for finding in read.findings],
    )
