"""Carries out the requests to one engine, from every interface."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping, Sequence
from contextlib import AbstractAsyncContextManager
from dataclasses import replace
from functools import partial
from itertools import chain, count
from typing import Any, Protocol

from bt_orchestrator.base.errors import CommandRefused, NotRead, Refused
from bt_orchestrator.engine.asking.commands import (
    asked_by_name,
    prepared,
    stop_number,
    unknown_code,
    without_code,
)
from bt_orchestrator.engine.asking.orders import (
    Told,
    answer_to_refused,
    changed_job,
    check_place,
    check_sender,
    job_anew,
    refused_orders,
    wanted_orders,
    with_each,
)
from bt_orchestrator.engine.runtime.job_queue import allowed
from bt_orchestrator.engine.runtime.orchestrator import Orchestrator
from bt_orchestrator.model.by import By, Control
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.commands import Answer, OrderAnswer, RefusedRequest
from bt_orchestrator.model.jobs import job_control
from bt_orchestrator.model.jobs.job_commands import AddJobs, RequeueJob, UpdateJob
from bt_orchestrator.model.jobs.needs import needed_by
from bt_orchestrator.model.jobs.order import Job, MadeAnew, order_id_fault
from bt_orchestrator.model.plant.shifts import PlantReason
from bt_orchestrator.model.proof.pace import pace
from bt_orchestrator.model.requests import (
    ADD,
    CLASSIFY,
    CONTROLS,
    REQUEUE,
    UPDATE,
    Asked,
    BadArguments,
    Why,
    about_of,
    of_name,
)
from bt_orchestrator.model.script import Script
from bt_orchestrator.model.state import CellState, JobState
from bt_orchestrator.model.words import sentence
from bt_orchestrator.ports import ActionTypes, StopSearch
from bt_orchestrator.script.given_values import arguments_of
from bt_orchestrator.script.orders.asked import change_of
from bt_orchestrator.script.orders.desk import AskedOrder, ChangedJob, Reading, Wanted

TO_LOCAL = CONTROLS[Control.LOCAL]

_Step = Callable[[Asked], Awaitable[Answer]]


class OrderReading(Protocol):
    """Reads orders, here or in another process."""

    def read(self, wanted: Wanted | Callable[[], Wanted]) -> AbstractAsyncContextManager[Reading]:
        """Read them in their turn; that of the next ones comes when the block has ended.

        :raises NotRead: says why nothing was read
        """


class RequestHandler:
    """Answers requests. Refusals are on record as well."""

    def __init__(
        self,
        engine: Orchestrator,
        types: ActionTypes,
        orders: OrderReading,
        why_no_panel: Callable[[], str] = lambda: sentence('no_panels'),
        reasons: Mapping[str, PlantReason] | None = None,
        stops: StopSearch | None = None,
    ) -> None:
        """Answer for an engine.

        :param why_no_panel: says why no request comes from a panel (7.8); empty: one may
        :param reasons: of the plant for stops, by code; None: it has no file of them
        :param stops: looks for stops in the journal; None: there is none
        """
        self._engine = engine
        self._types = types
        self._orders = orders
        self.why_no_panel = why_no_panel
        self._reasons = reasons
        self._stops = stops
        self._reads: Mapping[str, _Step] = {
            CLASSIFY.name: self._classify,
            ADD.name: self._add,
            UPDATE.name: self._update,
            REQUEUE.name: self._requeue,
            TO_LOCAL.name: self._to_local,
        }
        """Carries out the requests for which files are read."""

    async def carry_out(self, asked: Asked) -> Answer:
        """Carry out a request of the table."""
        reads = self._reads.get(asked.request.name)
        return await self._answer(asked, self._decide if reads is None else reads)

    async def carry_out_named(self, name: str, given: Mapping[str, Any] | str, by: By) -> Answer:
        """Carry out a request by its name; refuse one that the table does not have.

        :param given: arguments by name, or their text in JSON or YAML
        """
        arguments: Mapping[str, Any] = {}
        try:
            arguments = arguments_of(given) if isinstance(given, str) else given
            asked = asked_by_name(name, by, arguments, self._engine.state)
        except (BadArguments, CommandRefused) as why:
            return await self.refuse_named(name, arguments, by, str(why))
        return await self.carry_out(asked)

    async def refuse_named(
        self, name: str, arguments: Mapping[str, Any], by: By, why: str
    ) -> Answer:
        """Put a request on record that is refused, whether the table has it or not."""
        request, about = of_name(name), about_of(name, arguments)
        word = name.rpartition('.')[2] if request is None else request.word
        return await self._engine.carry_out(RefusedRequest(word, by, why, about=about))

    async def add(
        self,
        orders: Sequence[AskedOrder],
        by: By,
        position: int | None = None,
        *,
        held: bool = False,
    ) -> Answer:
        """Queue orders in their order, all or none."""
        given = {'orders': orders, 'position': position, 'held': held}
        return await self.carry_out(Asked(ADD, by, given))

    async def update(self, job: str, wish: AskedOrder, by: By) -> Answer:
        """Change a queued job; keep what the request does not name."""
        return await self._answer(Asked(UPDATE, by, {'job': job}), partial(self._change, wish))

    async def make_anew(self, job: str, by: By) -> Answer:
        """Generate the script of a queued job by recipe again, without what is out of service.

        Everything else of the job stays. It is on record only if another script comes of it.
        """
        return await self._answer(Asked(UPDATE, by, {'job': job}), self._make_anew)

    async def _answer(self, asked: Asked, step: _Step) -> Answer:
        try:
            check_place(asked, self._engine.state)
            return await step(asked)
        except (CommandRefused, NotRead) as why:
            return await self._refuse(asked, str(why))

    async def _refuse(self, asked: Asked, message: str) -> Answer:
        """Put a request on record that cannot be made a command."""
        word, about = asked.request.word, asked.about
        refused = RefusedRequest(word, asked.sender, message, about=about)
        return await self._engine.carry_out(refused)

    async def _to_local(self, asked: Asked) -> Answer:
        """Hand the line over to its panels, if there is one that can give it back."""
        check_sender(asked)
        why = '' if asked.sender.known.is_panel else self.why_no_panel()
        if why:
            raise CommandRefused(sentence('needs_panel', words=why))
        return await self._decide(asked)

    async def _decide(self, asked: Asked) -> Answer:
        ready = prepared(asked, self._engine.state, self._types)
        why_not = unknown_code(ready, self._reasons)
        if why_not and ready.request.why is not Why.AFTERWARDS:
            raise CommandRefused(why_not)
        if why_not:  # an emergency is carried out, without what it cannot have
            answer = await self._engine.carry_out(without_code(ready))
            return replace(answer, message=f'{answer.message}; {why_not}')
        return await self._engine.carry_out(ready)

    async def _classify(self, asked: Asked) -> Answer:
        """Put the reason of a stop on record, if there is such a stop (7.10)."""
        check_sender(asked)
        if self._stops is None:
            raise CommandRefused(sentence('no_stop_names'))
        why_not = unknown_code(asked, self._reasons)
        if why_not:
            raise CommandRefused(why_not)
        if not asked['code'].strip():
            raise CommandRefused(sentence('empty_code'))
        seq = stop_number(asked['stop'], self._engine.state.history)
        if not await self._stops.has(seq):
            raise CommandRefused(sentence('no_such_stop', seq=seq))
        return await self._engine.carry_out(asked)

    # --- orders -----------------------------------------------------------------------------

    async def _add(self, asked: Asked) -> Answer:
        check_sender(asked)
        orders = wanted_orders(asked['orders'])
        async with self._orders.read(orders) as reading:
            read, given = reading.read, asked.arguments
            jobs = tuple(job for job in read if isinstance(job, Job))
            if len(jobs) < len(read):
                await self._engine.carry_out(refused_orders(asked, orders, read))
                return answer_to_refused(orders, read)
            held = bool(given.get('held', False))
            added = AddJobs(jobs, asked.sender, given.get('position'), held, reading.sharing)
            answer = await self._engine.carry_out(added)
            return with_each(answer, jobs, self._engine.state)

    async def _update(self, asked: Asked) -> Answer:
        check_sender(asked)
        if len(asked.arguments) < 2:
            names = ', '.join(
                parameter.name
                for parameter in UPDATE.parameters
                if parameter is not UPDATE.subject
            )
            raise CommandRefused(sentence('say_what', parameters=names))
        return await self._change(change_of(asked.arguments), asked)

    async def _change(self, wish: AskedOrder, asked: Asked) -> Answer:
        check_sender(asked)
        wanted_orders([wish])  # within the limits
        as_it_is = partial(changed_job, self._engine.state, asked['job'], wish)
        async with self._orders.read(as_it_is) as reading:
            return await self._update_read(asked, reading, keeps_script=wish.keeps_script)

    async def _update_read(
        self,
        asked: Asked,
        reading: Reading,
        anew: MadeAnew | None = None,
        *,
        keeps_script: bool = False,
    ) -> Answer:
        (read,) = reading.read
        if isinstance(read, Refused):
            return await self._refuse_read(asked, read)
        update = UpdateJob(read, asked.sender, reading.sharing, keeps_script, anew)
        answer = await self._engine.carry_out(update)
        return with_each(answer, [read], self._engine.state)

    async def _make_anew(self, asked: Asked) -> Answer:
        state, job = self._engine.state, asked['job']
        async with self._orders.read(partial(job_anew, state, job)) as reading:
            (read,), queued, anew = reading.read, state.jobs.get(job), None
            if isinstance(read, Job) and queued is not None:
                if digest(read.script) == queued.digest:
                    return Answer(accepted=True, message=sentence('made_as_before', job=job))
                anew = made_anew(queued, read.script, state)
                reason = f'{asked.sender.reason}; made anew: {anew.pace_words}'
                asked = replace(asked, by=replace(asked.sender, reason=reason))
            return await self._update_read(asked, reading, anew)

    async def _requeue(self, asked: Asked) -> Answer:
        """End a job on the line early, and queue its rest anew: both or neither (7.6)."""
        check_sender(asked)
        state, job = self._engine.state, asked['job']
        as_it_is = partial(rest_of, state, job, asked.arguments.get('order', ''))
        async with self._orders.read(as_it_is) as reading:
            (read,), live = reading.read, state.jobs[job]
            if isinstance(read, Refused):
                return await self._refuse_read(asked, read)
            same = digest(read.script) == live.digest
            anew = None if same else made_anew(live, read.script, state)
            requeue = RequeueJob(job, read, asked.sender, reading.sharing, anew)
            return await self._engine.carry_out(requeue)

    async def _refuse_read(self, asked: Asked, read: Refused) -> Answer:
        await self._refuse(asked, read.in_short)
        each = OrderAnswer(message=read.count, findings=Told().of(read))
        return Answer(accepted=False, message=read.count, orders=(each,))


# The differences between a script that was generated again and the one of the job.


def made_anew(job: JobState, now: Script, state: CellState) -> MadeAnew:
    """Return which components make the difference, and the pace."""
    cell, before = state.cell, job.anew
    needed = needed_by(job.job.script, cell)
    lacked = before.without if before is not None else ()
    without = tuple(
        component
        for component in state.out_of_service
        if component in needed or component in lacked
    )
    back = () if without else tuple(sorted(needed_by(now, cell) - needed))
    # What the job lacks already was not in its last pace.
    known_s = before.before_s if before is not None and before.without else 0.0
    return MadeAnew(
        without, back, _per_item_s(now, cell), known_s or _per_item_s(job.job.script, cell)
    )


def _per_item_s(script: Script, cell: Cell) -> float:
    """Return seconds from one item to the next; 0: not known."""
    line_pace = pace(script, cell)
    return 0.0 if line_pace is None else line_pace.per_item_s


# The order for what a job on the line has not begun (semantics 7.6).

REST = '-rest'
"""Behind the id of a job in that of its rest."""


def rest_of(state: CellState, job: str, order: str) -> ChangedJob:
    """Return the order for the rest of a job, in its present state.

    :param order: id of the rest; empty: one that is free
    :raises NotRead: the job has no rest that can be made, or the id cannot be one
    """
    try:
        live = allowed(state, job_control.REQUEUE, job)
    except CommandRefused as why:
        raise NotRead(str(why)) from None
    name = order or _free_id(state, live)
    fault = order_id_fault(name)
    if fault is not None:
        raise NotRead(sentence('no_rest_id', id=repr(name), words=fault))
    wish, had = AskedOrder(recipe=live.job.recipe), live.job
    return ChangedJob(name, live.digest, live.cycles_left, had.params, wish, had.terms, had.recipe)


def _free_id(state: CellState, job: JobState) -> str:
    """Return an id that no order had; that of the rest of a rest counts on."""
    base, _, _ = job.job.id.rpartition(REST) if job.rest_of else ('', '', '')
    first = f'{base or job.job.id}{REST}'
    names = chain([first], (f'{first}-{number}' for number in count(2)))
    return next(name for name in names if name not in state.order_ids)
