"""Orders by recipe: scripts are generated before the orders are read, and anew while they wait."""

from __future__ import annotations

import logging
from collections.abc import AsyncIterator, Callable, Iterable, Sequence
from contextlib import asynccontextmanager
from dataclasses import replace

from bt_orchestrator.base.errors import Refused
from bt_orchestrator.base.replies import begin
from bt_orchestrator.engine.asking.handler import OrderReading, RequestHandler
from bt_orchestrator.model import events as e
from bt_orchestrator.model.by import By, Known, Role
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.jobs.needs import released_before
from bt_orchestrator.model.jobs.order import RecipeChoice
from bt_orchestrator.model.state import CellState, JobState
from bt_orchestrator.ports import Generating, MadeScript
from bt_orchestrator.script.orders.desk import MadeScripts, Reading, Wanted
from bt_orchestrator.script.writing.script_text import write_script


class RecipeOrders:
    """Reads orders, with scripts that are generated for them. Implements `handler.OrderReading`.

    Whoever names scripts does not wait for those who name recipes: a request with recipes gives
    its turn away while they are generated. Then it is read as a whole, and is queued against the
    queue as it is then.
    """

    def __init__(self, orders: OrderReading, generating: Generating, state: CellState) -> None:
        self._orders = orders
        self._generating = generating
        self._state = state

    @asynccontextmanager
    async def read(self, wanted: Wanted | Callable[[], Wanted]) -> AsyncIterator[Reading]:
        """Read them in their turn; that of the next ones comes when the block has ended.

        :raises NotRead: says why nothing was read
        """
        made: MadeScripts = ()
        while True:
            async with self._orders.read(_with(made, wanted)) as reading:
                choices = [choice for choice in reading.choices if choice is not None]
                if not choices:
                    yield reading
                    return
            # More than once only if the job that is to be changed was changed meanwhile.
            made = await self._made(choices)

    async def _made(self, choices: Sequence[RecipeChoice]) -> MadeScripts:
        """Return what is made, without what is out of service when it is done.

        A script that was released for the same is taken in its place (semantics 6.11).
        """
        different = [choice for at, choice in enumerate(choices) if choice not in choices[:at]]
        while True:
            without = frozenset(self._state.out_of_service)
            made = await self._generating.make(different, without)
            if without == frozenset(self._state.out_of_service):
                return tuple(zip(different, map(self._released, made), strict=True))

    def _released(self, made: MadeScript | Refused) -> MadeScript | Refused:
        if isinstance(made, Refused) or made.made_from is None:
            return made
        before = released_before(self._state, made.made_from, made.digest)
        if before is None:
            return made
        text = write_script(before, None)
        return MadeScript(made.name, text, digest(before), before.made_from)


def _with(
    made: MadeScripts, wanted: Wanted | Callable[[], Wanted]
) -> Wanted | Callable[[], Wanted]:
    """Return orders with the scripts made for them; a job is changed in its state at its turn."""
    if callable(wanted):
        as_it_is = wanted
        return lambda: replace(as_it_is(), made=made)
    return replace(wanted, made=made)


# Queued jobs by recipe follow what is out of service: their scripts are generated anew (7.5).

log = logging.getLogger(__name__)

WHO, ORIGIN = 'bt_orchestrator', 'the node, by itself'
"""The node, as the author of such a change of a job in its record."""


_OF_INTEREST = (
    e.ComponentOutOfService,
    e.ComponentInService,
    e.OrchestratorStarted,
    e.OrderEvent,
)


class QueueAnew:
    """Has one job after the other made anew, behind what brought it about.

    Implements `ports.EventSink`. A job that cannot be made stays as it is, with the reason on
    record. Nothing is lost with the node: the next one begins with the jobs that lack a component.
    """

    def __init__(
        self,
        handler: RequestHandler,
        state: CellState,
        later: Callable[[Callable[[], object]], object],
    ) -> None:
        """Follow the events of an engine.

        :param later: calls a function when the events have been published
        """
        self._handler = handler
        self._state = state
        self._later = later
        self._wanted: dict[str, str] = {}
        """Why, by job; a job that has a reason anew is made for that alone."""
        self._works = False

    def publish(self, events: Sequence[e.Event]) -> None:
        """Note which jobs have to be made anew."""
        for event in events:
            if isinstance(event, _OF_INTEREST):
                self._note(event)
        if self._wanted and not self._works:
            self._works = True
            self._later(lambda: begin(self._work()))

    def _note(self, event: e.Event) -> None:
        if isinstance(event, e.ComponentOutOfService):
            without = [job for job in self._state.queue if event.component in job.unavailable]
            self._want(without, f'{event.component} is out of service')
        elif isinstance(event, e.ComponentInService):
            self._want(self._state.queue, f'{event.component} is in service')
        elif isinstance(event, e.OrchestratorStarted):
            for job in self._state.queue:
                self._want([job] if job.unavailable else [], f'{_names(job)} out of service')
        elif isinstance(event, e.OrderEvent) and event.unavailable:
            # What it needs went out of service while it was read.
            there = [job for job in (self._state.jobs.get(event.job),) if job is not None]
            self._want(there, f'{_names(event)} out of service')

    def _want(self, jobs: Iterable[JobState], why: str) -> None:
        self._wanted |= {job.job.id: why for job in jobs if job.job.recipe is not None}

    async def _work(self) -> None:
        while self._wanted:
            name = next(iter(self._wanted))
            why = self._wanted.pop(name)
            job = self._state.jobs.get(name)
            if job is not None and not job.started and not job.ending:
                await self._make(name, By(WHO, ORIGIN, why, Role.ENGINEER, Known.LOCAL_USER))
        self._works = False

    async def _make(self, name: str, by: By) -> None:
        try:
            await self._handler.make_anew(name, by)
        except Exception:  # whatever it is, the other jobs and those after them are made
            log.exception('%s could not be made anew', name)


def _names(job: JobState | e.OrderEvent) -> str:
    verb = 'is' if len(job.unavailable) == 1 else 'are'
    return f'{" and ".join(job.unavailable)} {verb}'
