"""The course of a demo in front of a person: submitting, looking, and when it is over."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING

from bt_orchestrator.base.errors import NodeUnreachable
from bt_orchestrator.base.stop_signals import StopSignals
from bt_orchestrator.cli.demo.dialogue import Dialogue
from bt_orchestrator.cli.demo.programs import READY_S, DemoPrograms
from bt_orchestrator.cli.door import STEP_S, Ignoring
from bt_orchestrator.cli.node_options import origin
from bt_orchestrator.cli.ordering.order_request import for_node
from bt_orchestrator.cli.programs import ProgramFailed
from bt_orchestrator.model.by import By
from bt_orchestrator.model.events import Event, JobAborted, JobCompleted
from bt_orchestrator.model.jobs.isa95 import OVER
from bt_orchestrator.model.jobs.order import WorkOrder
from bt_orchestrator.model.packml import PackmlState
from bt_orchestrator.model.requests import ask
from bt_orchestrator.model.state import Hold
from bt_orchestrator.model.status import CellStatus, JobStatus
from bt_orchestrator.ports import CellLink
from bt_orchestrator.view.screen.plain import EventLines

if TYPE_CHECKING:  # it needs rich, which takes its time
    from bt_orchestrator.view.screen.live import LiveView


class Interrupted(Exception):
    """Somebody wants the demo to end."""


class DemoShow(Ignoring):
    """One order on a line whose programs run."""

    def __init__(
        self,
        programs: DemoPrograms,
        viewer: LiveView | EventLines,
        dialogue: Dialogue,
        stop: StopSignals,
    ) -> None:
        self._programs = programs
        self._viewer = viewer
        self._dialogue = dialogue
        self._stop = stop
        self._heard: CellStatus | None = None
        self._job = ''
        self._ended: set[str] = set()

    def look(self) -> None:
        """Do what has to be done all the time, whatever is waited for.

        :raises ProgramFailed: the tree node has gone
        :raises Interrupted: somebody wants an end
        """
        if self._stop.requested:
            raise Interrupted
        self._programs.check()
        if self._job and self._of_job() is not None:  # what came before it is over soon
            self._dialogue.look(self._status)
        about = (*self._programs.about_servers(), self._programs.about_node())
        self._viewer.on_notes([*self._dialogue.lines(), *about])
        self._viewer.refresh()

    def follow(
        self, door: CellLink, order: WorkOrder, *, asks: bool, stays: bool = False
    ) -> tuple[str, Sequence[Hold]]:
        """Give the order unless it is there, and look until nothing goes on.

        :param asks: a hold does not end the demo
        :param stays: only somebody who wants an end ends it
        :return: the id of its job, and what is held
        """
        door.follow(self)
        self._wait_for_servers(door)
        self._job = self._ordered(door, order)
        while not self._is_over(asks=asks):
            door.turn(STEP_S)
        with contextlib.suppress(Interrupted):
            while stays:
                door.turn(STEP_S)
        return self._job, self._status.holds

    def on_status(self, status: CellStatus) -> None:
        """Show a status that knows the order: what a cell without one waits for is no news."""
        self._heard = status
        if self._job and self._of_job() is not None:
            self._viewer.on_status(status)

    def on_event(self, event: Event) -> None:
        """Show what happened, and notice the end of a job."""
        self._viewer.on_event(event)
        if isinstance(event, JobCompleted | JobAborted):
            self._ended.add(event.job)

    def _wait_for_servers(self, door: CellLink) -> None:
        deadline = time.monotonic() + READY_S
        while not self._all_are_there():
            if time.monotonic() > deadline:
                raise NodeUnreachable(
                    f'the node did not see all action servers within {READY_S:g} s; '
                    '`bt-orchestrator doctor` tells why'
                )
            door.turn(STEP_S)

    def _all_are_there(self) -> bool:
        return self._heard is not None and all(c.available for c in self._heard.components)

    def _ordered(self, door: CellLink, order: WorkOrder) -> str:
        """Return the id of the order's job, which a resumed demo has already."""
        if order.order in {job.id for job in self._status.jobs}:
            return str(order.order)
        answer = door.ask(ask('queue.add', By('', origin(), ''), orders=[for_node(order)]))
        findings = [finding for one in answer.orders for finding in one.findings]
        if not answer.accepted:
            raise ProgramFailed('\n'.join([answer.message, *findings]))
        (queued,) = answer.orders
        return queued.job

    def _is_over(self, *, asks: bool) -> bool:
        """Tell whether the job has ended, or nothing goes on and no question is open."""
        job = self._of_job()
        ended = job is not None and job.state in OVER
        return (
            ended
            or self._job in self._ended
            or (not asks and self._status.state is PackmlState.HELD)
        )

    @property
    def _status(self) -> CellStatus:
        """How the cell stands; asked for when the node has said so."""
        assert self._heard is not None
        return self._heard

    def _of_job(self) -> JobStatus | None:
        """Return how the job stands; None: the node has not said so yet."""
        return next((one for one in self._status.jobs if one.id == self._job), None)
