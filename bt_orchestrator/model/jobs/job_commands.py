"""Commands to the queue and its jobs (semantics 6.6)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from bt_orchestrator.model.by import By
from bt_orchestrator.model.jobs.made_anew import MadeAnew
from bt_orchestrator.model.jobs.order import Job


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

    jobs: tuple[Job, ...]
    by: By | None = None
    """None: from the plan of a virtual run."""
    position: int | None = None
    """Of the first, from 1; None: by priority and start (semantics 6.7)."""
    held: bool = False
    sharing: Sharing | None = None
    """None: not checked yet."""


@dataclass(frozen=True)
class MoveJob:
    """Put a queued job at another place."""

    job: str
    position: int
    """From 1; jobs that have started are not in the queue."""
    by: By


@dataclass(frozen=True)
class RunNext:
    """Put a queued job in front of all others, and let it start."""

    job: str
    by: By


@dataclass(frozen=True)
class UpdateJob:
    """Change a queued job."""

    job: Job
    """What it is to be; its id names the job."""
    by: By
    sharing: Sharing | None = None
    keeps_script: bool = False
    """Nothing else was named or generated: what the script was made from stays on record."""
    anew: MadeAnew | None = None
    """Why its script was generated again; None: it was not."""


@dataclass(frozen=True)
class RequeueJob:
    """End a job on the line early, and queue its rest anew (semantics 7.6)."""

    job: str
    rest: Job
    """Its quantity is the one that is left when this is carried out."""
    by: By
    sharing: Sharing | None = None
    anew: MadeAnew | None = None


@dataclass(frozen=True)
class ControlJob:
    """Ask one of the methods of `job_control` of a job."""

    verb: str
    job: str
    by: By


@dataclass(frozen=True)
class StopAfter:
    """Let the line run empty and stop, or take that back."""

    after: str
    """item: begin no more items; job: begin no more jobs; never: go on."""
    by: By


JobCommand = AddJobs | MoveJob | RunNext | UpdateJob | RequeueJob | ControlJob | StopAfter
