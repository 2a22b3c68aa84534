"""PackML's counters: items that have left the line, by job and in all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from bt_orchestrator.model.jobs.isa95 import OVER
from bt_orchestrator.model.status import CellStatus, JobStatus


@dataclass(frozen=True)
class Count:
    """Items of one job."""

    job: str
    """Empty: there was no job yet."""
    processed: int = 0
    """Produced (semantics 6.2)."""
    defective: int = 0
    """Those of them that are not good."""


class Counter:
    """Counts the items that leave the line, from one status to the next, in one journal."""

    def __init__(self) -> None:
        self.processed = 0
        """Of all jobs, those before included that the first status listed."""
        self.defective = 0
        self.counts: Sequence[Count] = (Count(''),)
        """Of the jobs on the line in the order they started, else of the last one that ended."""
        self._known: dict[str, Count] = {}

    def show(self, status: CellStatus) -> None:
        """Count on."""
        found = {job.id: _count(job) for job in status.jobs if not job.position}
        for name, count in found.items():
            before = self._known.get(name, Count(name))
            self.processed += max(0, count.processed - before.processed)
            self.defective += max(0, count.defective - before.defective)
        self._known = found
        begun = [job for job in status.jobs if not job.position]
        shown = [job for job in begun if job.state not in OVER] or begun[-1:]
        self.counts = tuple(found[job.id] for job in shown) or (Count(''),)


def _count(job: JobStatus) -> Count:
    return Count(job.id, job.produced, job.produced - job.good)
