"""The figures of a run: times, throughput, bottleneck, utilisation (semantics 8.3)."""

from __future__ import annotations

import itertools
import statistics
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Bottleneck:
    """The section that limits the line."""

    section: int
    pace_s: float
    next_section: int | None
    """The next slowest section; None: there is no other."""
    margin_s: float
    """Seconds by which the next one is faster."""


@dataclass(frozen=True)
class JobForecast:
    """The figures of one job."""

    job: str
    script: str
    quantity: int
    packed: int = 0
    rejected: int = 0
    """Rejected items that left the line."""
    missing: int = 0
    """Never placed, or taken off the belt by hand."""
    nonconforming: int = 0
    started_s: float | None = None
    finished_s: float | None = None
    """Both from the first event on. None: it had not come to that when the events ended."""
    aborted: bool = False
    per_item_s: float | None = None
    """In steady state; None with fewer than two items packed."""
    bottleneck: Bottleneck | None = None
    """The section that limits this job; None: no work was done on it."""


@dataclass(frozen=True)
class WaitLoad:
    """How long something waited for one thing."""

    kind: str
    """A value of `model.wait.WaitKind`; several, joined by +, where it waited for both."""
    cause: str
    """The cause of its wait, in words."""
    waited_s: float
    share: float
    """Part of the total, 0 to 1."""


@dataclass(frozen=True)
class SectionLoad:
    """How a section spends its time."""

    section: int
    cycles: int
    busy_s: float
    """Seconds in which at least one of its tasks ran, initialization left out."""
    pace_s: float
    """Seconds from one item to the next if the section never had to wait for another one."""
    utilisation: float
    """Busy time as a part of the total, 0 to 1."""
    waits: tuple[WaitLoad, ...] = ()
    """The rest of the time, the longest first; empty if no waits were recorded."""

    @property
    def busy_per_cycle_s(self) -> float:
        """Seconds of work for one item."""
        return self.busy_s / self.cycles if self.cycles else 0.0


@dataclass(frozen=True)
class ComponentLoad:
    """How long a component works."""

    component: str
    tasks: int
    """Attempts, failed ones included."""
    busy_s: float
    utilisation: float
    """Busy time as a part of the total, 0 to 1."""
    waits: tuple[WaitLoad, ...] = ()
    """Waits while its next task could not start; for the rest of the time it had no task."""


@dataclass(frozen=True)
class Forecast:
    """The figures of a run; for one that did not end, up to its last event."""

    total_s: float
    """From the first event to the last."""
    per_item_s: float | None
    """Seconds between two packed items in steady state; of a mix of scripts the mean."""
    jobs: tuple[JobForecast, ...]
    """In the order queued."""
    sections: tuple[SectionLoad, ...]
    """Those that had cycles, in the order of the belt."""
    components: tuple[ComponentLoad, ...]
    """All of the cell, in the order of its file."""
    changeover_s: float = 0.0
    """Seconds of all changes of setups between jobs, of all components together."""

    @property
    def is_mix(self) -> bool:
        """Tell whether the jobs are of several scripts."""
        return are_mix(self.jobs)

    @property
    def bottleneck(self) -> Bottleneck | None:
        """The section with the slowest pace; of equals the first. None: nothing was worked on."""
        return slowest_section(self.sections)


def slowest_of(pace_s: Mapping[int, float]) -> Bottleneck | None:
    """Return the slowest of some sections, in the order of the belt; of equals the first."""
    ranking = sorted(pace_s, key=lambda section: -pace_s[section])
    if not ranking:
        return None
    slowest, *others = ranking
    return Bottleneck(
        section=slowest,
        pace_s=pace_s[slowest],
        next_section=others[0] if others else None,
        margin_s=pace_s[slowest] - (pace_s[others[0]] if others else 0.0),
    )


def are_mix(jobs: Iterable[JobForecast]) -> bool:
    """Tell whether jobs are of several scripts."""
    return len({job.script for job in jobs}) > 1


def slowest_section(loads: Iterable[SectionLoad]) -> Bottleneck | None:
    """Return the section with the slowest pace."""
    return slowest_of({load.section: load.pace_s for load in loads})


def mean_per_item_s(jobs: Iterable[JobForecast]) -> float | None:
    """Return the mean of some jobs, each item with the steady state of its own job.

    The change from one job to the next is never steady: items of one leave while those of the
    other come.
    """
    known = [(job.packed, job.per_item_s) for job in jobs if job.per_item_s is not None]
    items = sum(packed for packed, _ in known)
    return sum(packed * seconds for packed, seconds in known) / items if items else None


def at_best(interval_s: float | None, bottleneck: Bottleneck | None) -> float | None:
    """Return an interval that a line can hold: none is shorter than its bottleneck's.

    Where a line drains items leave it faster than they came.
    """
    if interval_s is None or bottleneck is None:
        return interval_s
    return max(interval_s, bottleneck.pace_s)


def steady_interval_s(times_s: Sequence[float]) -> float | None:
    """Return the median interval in the middle half: a line that fills or drains is not steady."""
    intervals = [later - earlier for earlier, later in itertools.pairwise(times_s)]
    edge = len(intervals) // 4
    middle = intervals[edge : len(intervals) - edge]
    return statistics.median(middle) if middle else None
