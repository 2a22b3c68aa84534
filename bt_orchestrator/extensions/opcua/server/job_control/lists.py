"""JobOrderList and JobOrderResponseList: as many jobs as a client can take in."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from asyncua import ua

from bt_orchestrator.extensions.opcua.server.job_control.structures import (
    Structures,
    encoded,
    listed,
)
from bt_orchestrator.model.jobs.isa95 import OVER
from bt_orchestrator.model.status import ListedJob
from bt_orchestrator.view.report.isa95.codes import states_of
from bt_orchestrator.view.report.isa95.job_order import job_order
from bt_orchestrator.view.report.isa95.job_response import has_response, response_of

MOST = 100
"""MaxDownloadableJobOrders: the most in JobOrderList. The queue of the cell may be longer."""

LEAST_ENDED = 30
"""The last jobs that ended are listed, however long the queue is."""


class _Made(NamedTuple):
    facts: object
    structure: ua.ExtensionObject


class JobLists:
    """Makes and encodes a structure anew only where its job has changed."""

    def __init__(self, structures: Structures) -> None:
        self._structures = structures
        self._orders: dict[str, _Made] = {}
        self._responses: dict[str, _Made] = {}

    def orders(self, jobs: Sequence[ListedJob]) -> ua.Variant:
        """Return the value of JobOrderList."""
        self._orders = {
            job.status.id: self._order(job, self._orders.get(job.status.id)) for job in jobs
        }
        return listed([order.structure for order in self._orders.values()])

    def responses(self, jobs: Sequence[ListedJob], interrupted: str) -> ua.Variant:
        """Return the value of JobOrderResponseList: of the jobs that have started.

        :param interrupted: why the line stands still, in words; empty: it does not
        """
        self._responses = {
            job.status.id: self._response(job, interrupted, self._responses.get(job.status.id))
            for job in jobs
            if has_response(job.status)
        }
        return listed([response.structure for response in self._responses.values()])

    def _order(self, job: ListedJob, made: _Made | None) -> _Made:
        status = job.status
        facts = (
            status.state,
            status.awaits_start,
            status.script,
            status.quantity,
            status.priority,
            status.start,
            status.due,
            job.params,
            job.details,
        )
        if made is not None and made.facts == facts:
            return made
        states = states_of(status.state, awaits_start=status.awaits_start)
        return _Made(facts, encoded(self._structures.order_and_state(job_order(job), states)))

    def _response(self, job: ListedJob, interrupted: str, made: _Made | None) -> _Made:
        response = response_of(job, interrupted)
        if made is not None and made.facts == response:
            return made
        return _Made(response, encoded(self._structures.response(response)))


def chosen(jobs: Iterable[ListedJob]) -> list[ListedJob]:
    """Return the jobs to be listed: the last that ended, those on the line, the first queued."""
    over: list[ListedJob] = []
    line: list[ListedJob] = []
    queue: list[ListedJob] = []
    for job in jobs:
        status = job.status
        (over if status.state in OVER else queue if status.position else line).append(job)
    line = line[:MOST]
    queue.sort(key=lambda job: job.status.position)
    room = MOST - len(line)
    ended = min(len(over), max(room - len(queue), min(LEAST_ENDED, room)))
    return [*over[len(over) - ended :], *line, *queue[: room - ended]]
