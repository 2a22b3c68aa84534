"""Requests about orders, once their orders were read (semantics 6.6)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar

from bt_orchestrator.model.by import By
from bt_orchestrator.model.jobs.order import Job, MadeAnew
from bt_orchestrator.model.requests import ADD, REQUEUE, UPDATE, Request


@dataclass(frozen=True)
class Sharing:
    """The result of the check of scripts that share flags (semantics 4.1), by their digests.

    A proof may take long; this allows it to be made in advance, in another process.
    """

    among: frozenset[str]
    """Scripts that were live, and the new ones. It holds for any part of them."""
    why_not: Mapping[str, str] = field(default_factory=dict)
    """By new script that does not fit to those before it, the reason."""


@dataclass(frozen=True)
class AddJobs:
    """Queue jobs in this order, all or none."""

    request: ClassVar[Request] = ADD
    about: ClassVar[Mapping[str, str]] = {}
    jobs: tuple[Job, ...]
    by: By | None = None
    """None: from the plan of a virtual run."""
    position: int | None = None
    """Of the first, from 1; None: by priority and start (semantics 6.7)."""
    held: bool = False
    sharing: Sharing | None = None
    """None: not checked yet."""

    @property
    def names(self) -> tuple[str, ...]:
        """Ids of the jobs, each with a record of its own."""
        return tuple(job.id for job in self.jobs)


@dataclass(frozen=True)
class UpdateJob:
    """Change a queued job."""

    request: ClassVar[Request] = UPDATE
    job: Job
    """The new order of the job; its id names the job."""
    by: By
    sharing: Sharing | None = None
    keeps_script: bool = False
    """Nothing else was named or generated: what the script was made from stays on record."""
    anew: MadeAnew | None = None
    """Why its script was generated again; None: it was not."""

    @property
    def about(self) -> Mapping[str, str]:
        """The field of records that names the job."""
        return {'job': self.job.id}


@dataclass(frozen=True)
class RequeueJob:
    """End a job on the line early, and queue its rest anew (semantics 7.6)."""

    request: ClassVar[Request] = REQUEUE
    job: str
    rest: Job
    """Its quantity is the one that is left when this is carried out."""
    by: By
    sharing: Sharing | None = None
    anew: MadeAnew | None = None

    @property
    def about(self) -> Mapping[str, str]:
        """The field of records that names the job."""
        return {'job': self.job}


OfOrders = AddJobs | UpdateJob | RequeueJob
