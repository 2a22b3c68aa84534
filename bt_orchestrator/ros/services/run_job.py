"""The action `~/run_job`: one work order, from the queue to its end.

A goal lives as long as its job. Everything happens in the executor's one thread: goal and cancel
requests are commands in the inbox of the cell, the ends of jobs come as events.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from action_msgs.msg import GoalStatus
from bt_orchestrator_interfaces.action import RunJob
from bt_orchestrator_interfaces.msg import JobStatus
from rclpy.node import Node

from bt_orchestrator.base.deadlines import NS_PER_S
from bt_orchestrator.base.errors import NotRead, Refused
from bt_orchestrator.base.replies import begin
from bt_orchestrator.engine.asking.handler import OrderReading
from bt_orchestrator.engine.asking.orders import (
    answer_to_refused,
    check_sender,
    refused_orders,
    wanted_orders,
)
from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.engine.runtime.overview import Overview
from bt_orchestrator.model.by import By
from bt_orchestrator.model.commands import Answer, RefusedRequest
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.jobs.job_commands import AddJobs
from bt_orchestrator.model.jobs.job_record import JobRecord
from bt_orchestrator.model.limits import QUEUE_SHOWN, REFUSED_GOALS, Allowance
from bt_orchestrator.model.requests import ADD, Asked, ask
from bt_orchestrator.ports.spare_log import SpareLog
from bt_orchestrator.ros.services.expected_ends import ExpectedEnds
from bt_orchestrator.ros.services.goal_server import GoalServer, ServedGoal
from bt_orchestrator.ros.services.services import Senders, written_order
from bt_orchestrator.ros.types.order_messages import asked_order
from bt_orchestrator.ros.types.status_messages import failure_message, item_message, job_message
from bt_orchestrator.script.orders.desk import Orders, Reading
from bt_orchestrator.view.report.ended_jobs import JobFold


@dataclass
class _Served:
    """A goal and its job."""

    goal: ServedGoal
    by: By
    status: JobStatus
    """The last one sent as feedback."""


class RunJobServer:
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
        self._being_read: list[ServedGoal] = []
        self._log = SpareLog(node.get_logger())
        self._refused = Allowance(REFUSED_GOALS)
        self._server = GoalServer(
            node,
            RunJob,
            '~/run_job',
            admits=self._admits,
            start=self._begin,
            cancel=self._cancel,
        )

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

    def _admits(self) -> bool:
        """Accept a goal, to say why if its order is refused, unless too many were refused."""
        if self._refused.left(time.monotonic()) >= 1:
            return True
        self._log.warning('run_job takes no goal now: too many orders were refused lately')
        return False

    def _begin(self, goal: ServedGoal) -> None:
        """Queue the order of a goal that was accepted, once it was read."""
        self._being_read.append(goal)
        begin(self._queue(goal))

    async def _queue(self, goal: ServedGoal) -> None:
        try:
            await self._queue_or_refuse(goal)
        except Exception as error:  # noqa: BLE001 - a bad goal never stops the node
            self._log.error(f'run_job failed: {error!r}')
            self._being_read = [other for other in self._being_read if other is not goal]
            self._refuse(goal, f'internal error, see the log of the node: {error!r}')

    async def _queue_or_refuse(self, goal: ServedGoal) -> None:
        asked, who = goal.request, self._senders.by(goal.request, 'run_job')
        try:
            check_sender(Asked(ADD, who))
            orders = wanted_orders([asked_order(asked.order)])
            wanted = written_order(asked.text) if asked.text else orders
            async with self._orders.read(wanted) as reading:
                self._being_read.remove(goal)
                await self._queue_read(goal, orders, reading, who)
        except NotRead as why:
            self._being_read.remove(goal)
            self._refuse(goal, (await self._note(who, str(why))).message)

    async def _queue_read(
        self, goal: ServedGoal, orders: Orders, reading: Reading, who: By
    ) -> None:
        if goal.is_cancel_requested:
            words = 'the goal was cancelled before its order was queued'
            self._refuse(goal, (await self._note(who, words)).message)
            return
        (read,) = reading.read
        if isinstance(read, Refused):
            asked = Asked(ADD, who)
            await self._orchestrator.carry_out(refused_orders(asked, orders, [read]))
            (order_answer,) = answer_to_refused(orders, [read]).orders
            self._refuse(goal, read.count, order_answer.findings)
            return
        # From now on its events are its own: it may even end before `carry_out` returns. An
        # order that was given before is refused there, and the events are not those of a goal.
        is_known = read.id in self._served or read.id in self._orchestrator.state.jobs
        if not is_known:
            self._served[read.id] = _Served(goal, who, JobStatus())
        command = AddJobs((read,), who, goal.request.position or None, sharing=reading.sharing)
        answer = await self._orchestrator.carry_out(command)
        if not answer.accepted:
            if not is_known:
                del self._served[read.id]
            self._refuse(goal, answer.message)

    async def _note(self, who: By, why: str) -> Answer:
        """Put on record that nothing was queued."""
        return await self._orchestrator.carry_out(RefusedRequest(ADD.word, who, why))

    async def _cancel(self, goal: ServedGoal) -> bool:
        """Abort the job of a goal; the goal ends when the last item has left the line."""
        if goal in self._being_read:
            return True  # it will not be queued
        matches = ((name, served) for name, served in self._served.items() if served.goal is goal)
        job, served = next(matches, ('', None))
        if served is None:
            return False
        who = self._senders.of_cancel(served.by)
        answer = await self._orchestrator.carry_out(ask('job.abort', who, job=job))
        if not answer.accepted:
            self._log.warning(f'run_job is not cancelled: {answer.message}')
        return answer.accepted

    # --- answers ----------------------------------------------------------------------------

    def _feed_back(self, job: str, ends: Mapping[str, float]) -> None:
        served, status = self._served[job], self._status(job, ends)
        if status is not None and status != served.status:
            served.status = status
            self._server.feed_back(served.goal, RunJob.Feedback(status=status))

    def _ends(self) -> Mapping[str, float]:
        """Return in how many seconds jobs are expected to end."""
        return self._expected.within_s(self._host.get_clock().now().nanoseconds / NS_PER_S)

    def _status(self, job: str, ends: Mapping[str, float]) -> JobStatus | None:
        state = self._orchestrator.state
        job_state = state.jobs.get(job) or state.ended.get(job)
        if job_state is None:
            return None
        return job_message(self._overview.job(job_state, ends))

    def _end(self, served: _Served, record: JobRecord) -> None:
        result = RunJob.Result(
            job=record.job,
            exit_status=record.status,
            message=record.reason,
            status=self._status(record.job, self._ends()) or served.status,
            items=list(map(item_message, record.items.values())),
            failures=list(map(failure_message, record.failures)),
        )
        self._conclude(served.goal, result)

    def _refuse(self, goal: ServedGoal, message: str, findings: Sequence[str] = ()) -> None:
        self._refused.use(1, time.monotonic())
        result = RunJob.Result(exit_status='refused', message=message, findings=list(findings))
        self._conclude(goal, result)

    def _conclude(self, goal: ServedGoal, result: RunJob.Result) -> None:
        if result.exit_status == 'completed':
            status = GoalStatus.STATUS_SUCCEEDED
        elif goal.is_cancel_requested:
            status = GoalStatus.STATUS_CANCELED
        else:
            status = GoalStatus.STATUS_ABORTED
        self._server.end(goal, status, result)
