"""Queued jobs by recipe follow what is out of service: their scripts are generated anew (7.5)."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Sequence

from bt_orchestrator.base.replies import begin
from bt_orchestrator.engine.asking.handler import RequestHandler
from bt_orchestrator.model import events as e
from bt_orchestrator.model.by import By, Known
from bt_orchestrator.model.roles import Role
from bt_orchestrator.model.state import CellState, JobState

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
