"""The record of a job and its items (ISA-95: job response), which outlives its events."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from bt_orchestrator.model.codec import from_plain, to_plain
from bt_orchestrator.model.jobs.counting import good_of, produced_of
from bt_orchestrator.model.jobs.order import NO_TERMS, Terms
from bt_orchestrator.model.state import JobState

QUEUED, RUNNING = 'queued', 'running'
"""Status of a job that waits, and that works."""

ABORTED, REMOVED = 'aborted', 'removed'
"""Two of the ways to end: its items were rejected; it left the queue without having started."""


@dataclass(frozen=True)
class Counts:
    """Counts of one job (semantics 6.2)."""

    started: int = 0
    placed: int = 0
    packed: int = 0
    rejected: int = 0
    missing: int = 0
    nonconforming: int = 0
    """Of the packed ones."""
    by_hand: int = 0
    """Of the missing, those that were placed and taken off the belt by hand."""

    @property
    def good(self) -> int:
        """Packed, and conforming as they left."""
        return good_of(self.packed, self.nonconforming)

    @property
    def produced(self) -> int:
        """Placed, and no longer on the line."""
        return produced_of(self.packed, self.rejected, self.by_hand)


@dataclass(frozen=True)
class FailureRecord:
    """One attempt that failed."""

    time: float
    task: str
    attempt: int
    reason: str
    message: str = ''
    section: int | None = None
    item: str | None = None
    results: Mapping[str, Any] = field(default_factory=dict)
    """The refused results (result_refused, duplicate_serial)."""
    round: int = 0
    """The number of the further round of its repeat, from 1; 0: the first pass, or no repeat."""
    controller_said: str = ''
    """Text of the controller's own result, cut."""

    def is_of(self, item: str, task: str) -> bool:
        """Tell whether it is an attempt of this task of this item."""
        return (self.item, self.task) == (item, task)


@dataclass
class ItemRecord:
    """One item, from its source cycle to its end."""

    item: str
    started: float
    ended: float | None = None
    how: str = ''
    """packed, rejected, by_hand or missing; empty while it is on the line."""
    nonconforming: list[str] = field(default_factory=list)
    rounds: dict[str, int] = field(default_factory=dict)
    """Further rounds that were begun, by the first task of their repeat."""
    results: dict[str, Mapping[str, Any]] = field(default_factory=dict)
    serial: str = ''
    """The last one that was read; empty: none."""
    lots: Mapping[str, str] = field(default_factory=dict)
    """The lots that go into it, by name."""
    clock_set_s: float = 0.0
    """By how much the clock was set between its start and its end, forward; negative: back."""

    @property
    def seconds(self) -> float | None:
        """How long it was on the line; None: it has not ended."""
        return None if self.ended is None else self.ended - self.started - self.clock_set_s

    good: bool | None = None
    """Whether it was packed and not nonconforming as it left; None: it is on the line, or was an
    empty position."""


@dataclass
class JobRecord:
    """One job, from its order to its end."""

    job: str
    script: str
    quantity: int
    queued: float
    digest: str = ''
    """Name of the script by what it says; empty: it is not known any more."""
    recipe: str = ''
    """Name of the recipe that the script was generated from; empty: none."""
    recipe_version: int | None = None
    rest_of: str = ''
    """The job whose items it makes that this had not begun (semantics 7.6); empty: none."""
    params: Mapping[str, Any] = field(default_factory=dict)
    terms: Terms = NO_TERMS
    started: float | None = None
    ended: float | None = None
    status: str = QUEUED
    """queued, running, or how it ended: completed, stopped, aborted, removed."""
    reason: str = ''
    """Why it was stopped or aborted."""
    counts: Counts = Counts()
    items: dict[str, ItemRecord] = field(default_factory=dict)
    failures: list[FailureRecord] = field(default_factory=list)
    first_piece: str = ''
    """The last item that was its first piece (semantics 6.12); empty: none was asked for."""
    first_piece_state: str = ''
    """approved, refused, or waits for it; empty: none was asked for."""
    complete: bool = True
    """False: its events were removed, and with them its items and failures."""
    clock_set_s: float = 0.0
    """By how much the clock was set between its start and its end, forward; negative: back."""

    @property
    def seconds(self) -> float | None:
        """How long it took; None: it did not start or end, or no event tells it any more."""
        if self.started is None or self.ended is None:
            return None
        seconds = self.ended - self.started - self.clock_set_s
        return seconds if self.complete or seconds >= 0.0 else None


def all_counts(counts: Counts) -> dict[str, int]:
    """Return counts as JSON carries them, with those that follow from others."""
    return {**vars(counts), 'good': counts.good, 'produced': counts.produced}


def record_of(job: JobState) -> JobRecord:
    """Return what stays of a job that ended when its events are gone."""
    names = [counter.name for counter in dataclasses.fields(Counts)]
    return JobRecord(
        job=job.job.id,
        script=job.job.script.name,
        quantity=job.job.quantity,
        queued=job.queued_at,
        digest=job.digest,
        recipe=job.recipe,
        recipe_version=job.recipe_version,
        rest_of=job.rest_of,
        params=job.job.params,
        terms=job.job.terms,
        started=job.started_at,
        ended=job.ended_at,
        status=job.exit_status,
        reason=job.end_reason,
        counts=Counts(**{name: getattr(job.progress, name) for name in names}),
        complete=False,
    )


def job_to_plain(job: JobRecord) -> dict[str, Any]:
    """Return a job as JSON carries it."""
    plain: dict[str, Any] = to_plain(job)
    return plain


def job_from_plain(plain: Mapping[str, Any]) -> JobRecord:
    """Return the job that a record tells of."""
    return from_plain(JobRecord, plain)
