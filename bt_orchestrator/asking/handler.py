"""Carries out the requests to one engine, from every interface."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping, Sequence
from contextlib import AbstractAsyncContextManager
from dataclasses import replace
from functools import partial
from typing import Any, Protocol

from bt_orchestrator.asking.commands import Arguments, asked_by_word, prepared
from bt_orchestrator.asking.comparing import made_anew
from bt_orchestrator.asking.orders import (
    Told,
    answer_to_refused,
    changed_job,
    check_sender,
    job_anew,
    refused_orders,
    wanted_orders,
    with_each,
)
from bt_orchestrator.asking.rest import rest_of
from bt_orchestrator.errors import CommandRefused, NotRead, Refused
from bt_orchestrator.model.by import By
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.commands import Answer, OrderAnswer, RefusedRequest
from bt_orchestrator.model.jobs.job_commands import AddJobs, RequeueJob, UpdateJob
from bt_orchestrator.model.jobs.made_anew import MadeAnew
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.requests import (
    ADD,
    REQUESTS,
    REQUEUE,
    UPDATE,
    About,
    Asked,
    BadArguments,
    ask,
    refusal,
)
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.runtime.orchestrator import Orchestrator
from bt_orchestrator.script.given_arguments import arguments_of
from bt_orchestrator.script.orders.asked import asked_of, change_of
from bt_orchestrator.script.orders.desk import AskedOrder, Reading, Wanted


class OrderReading(Protocol):
    """Reads orders, here or in another process."""

    def read(self, wanted: Wanted | Callable[[], Wanted]) -> AbstractAsyncContextManager[Reading]:
        """Read them in their turn; that of the next ones comes when the block has ended.

        :raises NotRead: says why nothing was read
        """


class RequestHandler:
    """Answers requests. What is refused is on record as well."""

    def __init__(self, engine: Orchestrator, types: ActionTypes, orders: OrderReading) -> None:
        self._engine = engine
        self._types = types
        self._orders = orders
        self._reads: Mapping[str, Callable[[Arguments, By], Awaitable[Answer]]] = {
            ADD.name: self._add_as_asked,
            UPDATE.name: self._update_as_asked,
            REQUEUE.name: self._requeue_as_asked,
        }
        """What carries out the requests for which files are read."""

    async def carry_out(self, asked: Asked) -> Answer:
        """Carry out a request of the table."""
        reads = self._reads.get(asked.request.name)
        if reads is not None:
            return await reads(asked.arguments, asked.sender)
        try:
            asked = prepared(asked, self._engine.state, self._types)
        except CommandRefused as why:
            return await self._refuse(asked.request.word, asked.sender, str(why))
        return await self._engine.carry_out(asked)

    async def carry_out_named(self, name: str, arguments: str, by: By) -> Answer:
        """Carry out a request that came as texts; refuse one that the table does not have.

        :param arguments: by name, JSON or YAML
        """
        try:
            asked = ask(name, by, **arguments_of(arguments))
        except (BadArguments, CommandRefused) as why:
            known = REQUESTS.get(name)
            return await self._refuse(name if known is None else known.word, by, str(why))
        return await self.carry_out(asked)

    async def give(self, about: About, word: str, by: By, **given: Any) -> Answer:
        """Carry out a request that came as a word and reads no orders; refuse unknown words."""
        try:
            asked = asked_by_word(about, word, by, given, self._engine.state)
        except CommandRefused as why:
            return await self._refuse(word, by, str(why))
        return await self.carry_out(asked)

    async def add(
        self, orders: Sequence[AskedOrder], by: By, position: int | None, *, held: bool
    ) -> Answer:
        """Queue orders in their order, all or none."""
        try:
            check_sender(ADD, by)
            async with self._orders.read(wanted_orders(orders)) as reading:
                return await self._add_read(orders, reading, by, position, held=held)
        except NotRead as why:
            return await self._refuse(ADD.word, by, str(why))

    async def _add_as_asked(self, given: Arguments, by: By) -> Answer:
        try:
            orders = [asked_of(one) for one in given['orders']]
        except CommandRefused as why:
            return await self._refuse(ADD.word, by, str(why))
        return await self.add(
            orders, by, given.get('position'), held=bool(given.get('held', False))
        )

    async def _add_read(
        self,
        orders: Sequence[AskedOrder],
        reading: Reading,
        by: By,
        position: int | None,
        *,
        held: bool,
    ) -> Answer:
        jobs = tuple(job for job in reading.read if isinstance(job, Job))
        if len(jobs) < len(reading.read):
            await self._engine.carry_out(refused_orders(orders, reading.read, by))
            return answer_to_refused(orders, reading.read)
        added = AddJobs(jobs, by, position, held, reading.sharing)
        answer = await self._engine.carry_out(added)
        return with_each(answer, jobs, self._engine.state)

    async def update(self, job: str, wish: AskedOrder, by: By) -> Answer:
        """Change a queued job; keep what the request does not name."""
        try:
            check_sender(UPDATE, by)
            wanted_orders([wish])  # within the limits
            as_it_is = partial(changed_job, self._engine.state, job, wish)
            async with self._orders.read(as_it_is) as reading:
                return await self._update_read(job, reading, by, keeps_script=wish.keeps_script)
        except NotRead as why:
            return await self._refuse(UPDATE.word, by, str(why), job)

    async def _update_as_asked(self, given: Arguments, by: By) -> Answer:
        job = str(given['job'])
        if len(given) < 2 and refusal(UPDATE, by) is None:
            names = ', '.join(one.name for one in UPDATE.parameters if one is not UPDATE.subject)
            return await self._refuse(UPDATE.word, by, f'say what to change: {names}', job)
        try:
            wish = change_of(given)
        except CommandRefused as why:
            return await self._refuse(UPDATE.word, by, str(why), job)
        return await self.update(job, wish, by)

    async def _update_read(
        self,
        job: str,
        reading: Reading,
        by: By,
        anew: MadeAnew | None = None,
        *,
        keeps_script: bool = False,
    ) -> Answer:
        (read,) = reading.read
        if isinstance(read, Refused):
            return await self._refuse_read(UPDATE.word, read, by, job)
        update = UpdateJob(read, by, reading.sharing, keeps_script, anew)
        answer = await self._engine.carry_out(update)
        return with_each(answer, [read], self._engine.state)

    async def make_anew(self, job: str, by: By) -> Answer:
        """Generate the script of a queued job by recipe again, without what is out of service.

        Everything else of the job stays. It is on record only if another script comes of it.
        """
        try:
            async with self._orders.read(partial(job_anew, self._engine.state, job)) as reading:
                return await self._anew_read(job, reading, by)
        except NotRead as why:
            return await self._refuse(UPDATE.word, by, str(why), job)

    async def _anew_read(self, job: str, reading: Reading, by: By) -> Answer:
        (read,), queued = reading.read, self._engine.state.jobs.get(job)
        if isinstance(read, Job) and queued is not None:
            if digest(read.script) == queued.digest:
                return Answer(accepted=True, message=f'{job} is made as before')
            anew = made_anew(queued, read.script, self._engine.state)
            by = replace(by, reason=f'{by.reason}; made anew: {anew.pace_words}')
            return await self._update_read(job, reading, by, anew)
        return await self._update_read(job, reading, by)

    async def _requeue_as_asked(self, given: Arguments, by: By) -> Answer:
        """End a job on the line early, and queue its rest anew: both or neither (7.6)."""
        job = given['job']
        try:
            check_sender(REQUEUE, by)
            as_it_is = partial(rest_of, self._engine.state, job, given.get('order', ''))
            async with self._orders.read(as_it_is) as reading:
                return await self._requeue_read(job, reading, by)
        except NotRead as why:
            return await self._refuse(REQUEUE.word, by, str(why), job)

    async def _requeue_read(self, job: str, reading: Reading, by: By) -> Answer:
        (read,), live = reading.read, self._engine.state.jobs[job]
        if isinstance(read, Refused):
            return await self._refuse_read(REQUEUE.word, read, by, job)
        same = digest(read.script) == live.digest
        anew = None if same else made_anew(live, read.script, self._engine.state)
        return await self._engine.carry_out(RequeueJob(job, read, by, reading.sharing, anew))

    async def _refuse_read(self, verb: str, read: Refused, by: By, job: str) -> Answer:
        await self._refuse(verb, by, read.in_short, job)
        each = OrderAnswer(message=read.count, findings=Told().of(read))
        return Answer(accepted=False, message=read.count, orders=(each,))

    async def _refuse(self, verb: str, by: By, message: str, *jobs: str) -> Answer:
        """Put a request on record that cannot be made a command."""
        return await self._engine.carry_out(RefusedRequest(verb, by, message, jobs))
