"""What may be asked of the queue and of its jobs (semantics 6.6)."""

from __future__ import annotations

from dataclasses import dataclass

from bt_orchestrator.model.by import By
from bt_orchestrator.model.order import Job


@dataclass(frozen=True)
class AddJobs:
    """Queue jobs in this order, all or none."""

    jobs: tuple[Job, ...]
    by: By | None = None
    """None: nobody, it is the plan of a virtual run."""
    position: int | None = None
    """Of the first, from 1; None: the end."""
    held: bool = False


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


JobCommand = AddJobs | MoveJob | RunNext | UpdateJob | ControlJob | StopAfter
