"""The action `~/run_job`: one work order, from the queue to its end.

A goal lives as long as its job. Everything happens in the executor's one thread: goal and cancel
requests are commands in the inbox of the cell, the ends of jobs come as events.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from bt_orchestrator_interfaces.action import RunJob
from bt_orchestrator_interfaces.msg import FailureReport, ItemReport, JobStatus
from rclpy.action.server import ActionServer, CancelResponse, GoalResponse
from rclpy.node import Node

from bt_orchestrator.asking.handler import OrderReading
from bt_orchestrator.asking.orders import (
    answer_to_refused,
    check_sender,
    refused_orders,
    wanted_orders,
)
from bt_orchestrator.deadlines import NS_PER_S
from bt_orchestrator.errors import NotRead, Refused
from bt_orchestrator.model.allowance import Allowance
from bt_orchestrator.model.by import By
from bt_orchestrator.model.codec import json_of
from bt_orchestrator.model.commands import Answer, RefusedRequest
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.jobs.job_commands import AddJobs, ControlJob
from bt_orchestrator.model.jobs.job_record import FailureRecord, ItemRecord, JobRecord
from bt_orchestrator.model.limits import QUEUE_SHOWN, REFUSED_GOALS
from bt_orchestrator.model.requests import ADD
from bt_orchestrator.replies import begin
from bt_orchestrator.report.jobs import JobFold
from bt_orchestrator.ros.qos import SERVICES
from bt_orchestrator.ros.services.expected_ends import ExpectedEnds
from bt_orchestrator.ros.services.order_requests import asked_order, written_order
from bt_orchestrator.ros.services.senders import Senders
from bt_orchestrator.ros.stamps import to_time
from bt_orchestrator.ros.types.job_messages import job_message
from bt_orchestrator.runtime.orchestrator import Orchestrator
from bt_orchestrator.runtime.overview import Overview
from bt_orchestrator.script.orders.desk import Reading
from bt_orchestrator.spare_log import SpareLog

RESULT_TIMEOUT_S = 900
"""How long a result is kept for a client that comes back for it."""

ON_THE_LINE = 'on_the_line'
"""Outcome of an item that has not ended."""


@dataclass
class _Served:
    """A goal and its job."""

    handle: Any
    by: By
    status: JobStatus
    """The last one sent as feedback."""


class RunJobServer(ActionServer):  # type: ignore[type-arg] # no Generic in Jazzy's rclpy
    """Serves `~/run_job`. Implements `ports.EventSink`.

    A goal is accepted whatever its order is, for a refusal has no words in ROS 2: one with
    mistakes ends at once, aborted, with the findings in its result. As these are kept for a
    while, goals are refused while there are too many of them.
    """

    def __init__(
        self,
        node: Node,
        orchestrator: Orchestrator,
        overview: Overview,
        orders: OrderReading,
        expected: ExpectedEnds,
        senders: Senders,
    ) -> None:
        self._host = node
        self._senders = senders
        self._orchestrator = orchestrator
        self._overview = overview
        self._orders = orders
        self._expected = expected
        self._served: dict[str, _Served] = {}
        """By job."""
        self._fold = JobFold()
        """The records of these jobs."""
        self._being_read: list[Any] = []
        self._log = SpareLog(node.get_logger())
        self._refused = Allowance(REFUSED_GOALS)
        super().__init__(
            node,
            RunJob,
            '~/run_job',
            execute_callback=_never_called,
            goal_callback=self._admit,
            handle_accepted_callback=self._begin,
            cancel_callback=self._cancel,  # type: ignore[arg-type] # rclpy awaits it
            result_timeout=RESULT_TIMEOUT_S,
            goal_service_qos_profile=SERVICES,
            cancel_service_qos_profile=SERVICES,
            result_service_qos_profile=SERVICES,
            feedback_pub_qos_profile=SERVICES,
        )

    def notify_execute(self, goal_handle: Any, execute_callback: Any) -> None:
        """Do nothing when a goal starts: rclpy would resume a waiting coroutine at every turn."""

    def publish(self, events: Sequence[Event]) -> None:
        """Take in durable events: tell how jobs stand, and end the goals of those that ended.

        Of a long queue the first jobs are told how they stand, and those that the events name.
        """
        if not self._served:
            return
        named = self._follow(events)
        near = {job.job.id for job in self._orchestrator.state.jobs.first(QUEUE_SHOWN)}
        ends = self._ends()
        for name in [name for name in self._served if name in named or name in near]:
            record = self._fold.jobs.get(name)
            if record is not None and record.ended is not None:
                del self._fold.jobs[name]
                self._end(self._served.pop(name), record)
            else:
                self._feed_back(name, ends)

    def _follow(self, events: Sequence[Event]) -> set[str]:
        """Bring the records up to date; returns the jobs that the events name."""
        named: set[str] = set()
        for event in events:
            name = getattr(event, 'job', None)
            if name in self._served:
                self._fold.follow(event)
                named.add(name)
        return named

    # --- requests ---------------------------------------------------------------------------

    def _admit(self, _: Any) -> GoalResponse:
        """Accept a goal, to say why if its order is refused, unless too many were refused."""
        if self._refused.left(time.monotonic()) >= 1:
            return GoalResponse.ACCEPT
        self._log.warning('run_job takes no goal now: too many orders were refused lately')
        return GoalResponse.REJECT

    def _begin(self, handle: Any) -> None:
        """Queue the order of a goal that was accepted, once it was read."""
        handle.execute()
        self._being_read.append(handle)

        begin(self._queue(handle))

    async def _queue(self, handle: Any) -> None:
        try:
            await self._queue_or_refuse(handle)
        except Exception as error:  # noqa: BLE001 - a bad goal never stops the node
            self._log.error(f'run_job failed: {error!r}')
            self._being_read = [one for one in self._being_read if one is not handle]
            self._refuse(handle, f'internal error, see the log of the node: {error!r}')

    async def _queue_or_refuse(self, handle: Any) -> None:
        goal, who = handle.request, self._senders.by(handle.request, 'run_job')
        try:
            check_sender(ADD, who)
            order = asked_order(goal.order)
            wanted = written_order(goal.text) if goal.text else wanted_orders([order])
            async with self._orders.read(wanted) as reading:
                self._being_read.remove(handle)
                await self._queue_read(handle, reading, who)
        except NotRead as why:
            self._being_read.remove(handle)
            self._refuse(handle, (await self._note(who, str(why))).message)

    async def _queue_read(self, handle: Any, reading: Reading, who: By) -> None:
        if handle.is_cancel_requested:
            words = 'the goal was cancelled before its order was queued'
            self._refuse(handle, (await self._note(who, words)).message)
            return
        goal, (read,) = handle.request, reading.read
        if isinstance(read, Refused):
            order = asked_order(goal.order)
            await self._orchestrator.carry_out(refused_orders([order], [read], who))
            (told,) = answer_to_refused([order], [read]).orders
            self._refuse(handle, read.count, told.findings)
            return
        # From now on its events are its own: it may even end before `carry_out` returns. An
        # order that was given before is refused there, and the events are not those of a goal.
        is_known = read.id in self._served or read.id in self._orchestrator.state.jobs
        if not is_known:
            self._served[read.id] = _Served(handle, who, JobStatus())
        command = AddJobs((read,), who, goal.position or None, sharing=reading.sharing)
        answer = await self._orchestrator.carry_out(command)
        if not answer.accepted:
            if not is_known:
                del self._served[read.id]
            self._refuse(handle, answer.message)

    async def _note(self, who: By, why: str) -> Answer:
        """Put on record that nothing was queued."""
        return await self._orchestrator.carry_out(RefusedRequest(ADD.word, who, why))

    async def _cancel(self, handle: Any) -> CancelResponse:
        """Abort the job of a goal; the goal ends when the last item has left the line."""
        if any(one is handle for one in self._being_read):
            return CancelResponse.ACCEPT  # it will not be queued
        found = ((name, one) for name, one in self._served.items() if one.handle is handle)
        job, served = next(found, ('', None))
        if served is None:
            return CancelResponse.REJECT
        who = self._senders.of_cancel(served.by)
        command = ControlJob('abort', job, who)
        # rclpy polls its own coroutines at every turn; this one goes on in its turn.
        answer = await begin(self._orchestrator.carry_out(command))
        if not answer.accepted:
            self._log.warning(f'run_job is not cancelled: {answer.message}')
        return CancelResponse.ACCEPT if answer.accepted else CancelResponse.REJECT

    # --- answers ----------------------------------------------------------------------------

    def _feed_back(self, job: str, ends: Mapping[str, float]) -> None:
        served, status = self._served[job], self._status(job, ends)
        if status is not None and status != served.status:
            served.status = status
            served.handle.publish_feedback(RunJob.Feedback(status=status))

    def _ends(self) -> Mapping[str, float]:
        """Return in how many seconds jobs are expected to end."""
        return self._expected.within_s(self._host.get_clock().now().nanoseconds / NS_PER_S)

    def _status(self, job: str, ends: Mapping[str, float]) -> JobStatus | None:
        state = self._orchestrator.state
        found = state.jobs.get(job) or state.ended.get(job)
        if found is None:
            return None
        return job_message(self._overview.job(found, ends))

    def _end(self, served: _Served, record: JobRecord) -> None:
        result = RunJob.Result(
            job=record.job,
            exit_status=record.status,
            message=record.reason,
            status=self._status(record.job, self._ends()) or served.status,
            items=[_item(item) for item in record.items.values()],
            failures=[_failure(failure) for failure in record.failures],
        )
        self._conclude(served.handle, result)

    def _refuse(self, handle: Any, message: str, findings: Sequence[str] = ()) -> None:
        self._refused.use(1, time.monotonic())
        result = RunJob.Result(exit_status='refused', message=message, findings=list(findings))
        self._conclude(handle, result)

    def _conclude(self, handle: Any, result: RunJob.Result) -> None:
        """End a goal soon, in a task of its own: the client may have gone long ago."""

        def conclude(handle: Any) -> Any:
            if result.exit_status == 'completed':
                handle.succeed()
            elif handle.is_cancel_requested:
                handle.canceled()
            else:
                handle.abort()
            return result

        super().notify_execute(handle, conclude)


def _item(item: ItemRecord) -> ItemReport:
    return ItemReport(
        id=item.item,
        outcome=item.how or ON_THE_LINE,
        nonconforming=item.nonconforming,
        results=json_of(item.results),
    )


def _failure(failure: FailureRecord) -> FailureReport:
    return FailureReport(
        stamp=to_time(failure.time),
        item=failure.item or '',
        task=failure.task,
        attempt=failure.attempt,
        reason=failure.reason,
        message=failure.message,
    )


def _never_called(handle: Any) -> Any:
    """Do nothing: rclpy requires a function, but goals are ended by events and never executed."""
    raise AssertionError(f'rclpy was told not to execute goals, and began {handle}')
