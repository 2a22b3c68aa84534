"""The eleven methods of the job order receiver: an order or an id in, ReturnStatus out."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping, Sequence
from typing import Any

from asyncua import ua

from bt_orchestrator.base.errors import NodeUnreachable
from bt_orchestrator.extensions.opcua.mes.methods import REQUESTS, STORING, refused
from bt_orchestrator.extensions.opcua.server.bridge import Bridge
from bt_orchestrator.extensions.opcua.server.calls import reason_of
from bt_orchestrator.extensions.opcua.server.job_control.job_orders import Jobs
from bt_orchestrator.extensions.opcua.server.job_control.status_events import StatusEvents
from bt_orchestrator.extensions.opcua.server.job_control.structures import comment_from, order_from
from bt_orchestrator.extensions.opcua.server.space import Call
from bt_orchestrator.extensions.opcua.server.values import Values
from bt_orchestrator.model.jobs import job_control
from bt_orchestrator.model.jobs.job_control import METHODS, Method
from bt_orchestrator.model.jobs.order import order_id_fault
from bt_orchestrator.model.status import ListedJob
from bt_orchestrator.ports.doors.tickets import Outcome
from bt_orchestrator.view.report.isa95.codes import ReturnStatus, Unfit
from bt_orchestrator.view.report.isa95.job_order import JobOrder, changes, reason_in, work_order


def answer(status: ReturnStatus, *outputs: ua.Variant) -> ua.CallMethodResult:
    """Return the result of a call; only Good and Uncertain let the outputs arrive.

    :param outputs: those before ReturnStatus
    """
    is_done = status is ReturnStatus.DONE
    code = ua.StatusCodes.Good if is_done else ua.StatusCodes.Uncertain
    result = ua.CallMethodResult()
    result.StatusCode = ua.StatusCode(code)
    number = ua.Variant(int(status), ua.VariantType.UInt64)
    result.OutputArguments = [*outputs, number]
    return result


def one(structure: Any) -> ua.Variant:
    """Return a structure as an output."""
    return ua.Variant(structure, ua.VariantType.ExtensionObject)


# A method answers when clients can read what it did: the standard has them look at once.

PATIENCE_S = 1.0
"""Longest wait for the status after a command; what is done stays done without it."""


class Shown:
    """All calls come from the server's loop."""

    def __init__(self, values: Values) -> None:
        self._values = values
        self._seq = 0
        self._waiting: list[tuple[int, asyncio.Future[None]]] = []

    def reached(self, seq: int) -> None:
        """Take note of the last event that the values contain."""
        self._seq = seq
        for wanted, future in self._waiting:
            if wanted < seq and not future.done():
                future.set_result(None)
        self._waiting = [waiter for waiter in self._waiting if not waiter[1].done()]

    async def wait(self, outcome: Outcome) -> None:
        """Wait until the values contain what a command did, but not for long."""
        # What follows from the record of a command is recorded behind it, in the same settle.
        wanted = max((event.seq for event in outcome.recorded), default=0)
        if wanted >= self._seq:
            future = asyncio.get_running_loop().create_future()
            self._waiting.append((wanted, future))
            await asyncio.wait([future], timeout=PATIENCE_S)
        await self._values.write()


_WITH_ORDER = (*STORING, job_control.UPDATE)


class Receiver:
    """Arguments first, then the role, then the cell; what it accepted is never an error."""

    def __init__(self, bridge: Bridge, jobs: Jobs, events: StatusEvents, shown: Shown) -> None:
        self._bridge = bridge
        self._jobs = jobs
        self._events = events
        self._shown = shown

    def calls(self) -> Mapping[str, Call]:
        """Return what carries out every method, by its name."""
        return {method.name: self._call(method) for method in METHODS}

    def _call(self, method: Method) -> Call:
        async def call(what: Any, comments: Sequence[ua.LocalizedText]) -> ua.CallMethodResult:
            comment = comment_from(comments)
            if method in _WITH_ORDER:
                return await self._with_order(method, what, comment)
            return await self._with_id(method, what, comment)

        return call

    async def _with_order(
        self, method: Method, structure: Any, comment: str
    ) -> ua.CallMethodResult:
        order = order_from(structure)
        reason = reason_of(comment or reason_in(order), method.name)
        try:
            arguments = await self._arguments(method, order)
        except Unfit as unfit:
            findings = [str(finding) for finding in unfit.findings]
            return self._refused(method, order.id, unfit.status, '; '.join(findings), findings)
        outcome = await self._bridge.calls.ask(REQUESTS[method], arguments, reason)
        return await self._answer(method, order.id, outcome)

    async def _arguments(self, method: Method, order: JobOrder) -> Mapping[str, object]:
        """Return the arguments of the request.

        :raises Unfit: the order cannot be taken like this
        """
        description = self._bridge.description
        components = [
            description.conveyor,
            *(component.name for component in description.components),
        ]
        name = next((master.id for master in order.work_masters), '')
        recipes = await self._bridge.orderable.recipe_names(name)
        if method is job_control.UPDATE:
            return changes(order, await self._now(order.id), components, recipes)
        held = {'held': True} if method is job_control.STORE else {}
        return {'orders': (work_order(order, components, recipes),), **held}

    async def _with_id(self, method: Method, job: str, comment: str) -> ua.CallMethodResult:
        fault = order_id_fault(job) if self._jobs.followed.get(job) is None else None
        if fault is not None:
            return self._malformed(method, job, f'{job!r} is no job order id: {fault}')
        reason = reason_of(comment, method.name)
        outcome = await self._bridge.calls.ask(REQUESTS[method], {'job': job}, reason)
        return await self._answer(method, job, outcome)

    # --- answers ----------------------------------------------------------------------------

    async def _answer(self, method: Method, job: str, outcome: Outcome) -> ua.CallMethodResult:
        if outcome.accepted:
            await self._shown.wait(outcome)
            return answer(ReturnStatus.DONE)
        now = None if method in STORING else await self._now(job)
        word, ending = (None, '') if now is None else (now.status.state, now.status.ending)
        status = refused(method, word, ending)
        return self._refused(method, job, status, outcome.message, outcome.findings)

    async def _now(self, job: str) -> ListedJob | None:
        """Return a job in its present state, or else in the last that was heard."""
        try:
            return await self._jobs.ask(job)
        except NodeUnreachable:
            return self._jobs.followed.get(job)

    def _malformed(self, method: Method, job: str, message: str) -> ua.CallMethodResult:
        return self._refused(method, job, ReturnStatus.MALFORMED, message, (message,))

    def _refused(
        self,
        method: Method,
        job: str,
        status: ReturnStatus,
        message: str,
        findings: Sequence[str] = (),
    ) -> ua.CallMethodResult:
        self._events.tell_refusal(method.name, job, status, message, findings)
        return answer(status)
