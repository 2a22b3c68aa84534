"""The output, by job."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import from_plain, to_plain
from bt_orchestrator.model.jobs.counting import kind_of


@dataclass
class Made:
    """Items of one job that left the line."""

    job: str
    script: str = ''
    digest: str = ''
    recipe: str = ''
    recipe_version: int | None = None
    good: int = 0
    nonconforming: int = 0
    """Packed, although a task failed or was let pass."""
    rejected: int = 0
    by_hand: int = 0
    """Taken off the belt by an operator."""
    outside: int = 0
    """Of any kind, but not in planned time: no other count has them."""

    @property
    def produced(self) -> int:
        """All that were made in planned time (ISO 22400: produced quantity)."""
        return self.good + self.bad

    @property
    def has_any(self) -> bool:
        """Tell whether anything left the line."""
        return bool(self.produced or self.outside)

    @property
    def bad(self) -> int:
        """Those that are not good."""
        return self.nonconforming + self.rejected + self.by_hand


class Left(NamedTuple):
    """An item that left the line."""

    of: Made
    """Its job, with no counts."""
    how: str
    is_bad: bool
    """It is nonconforming."""


class ItemsAtWork:
    """Takes in one event after another; keeps of an item only that it is nonconforming."""

    def __init__(self) -> None:
        self._jobs: dict[str, Made] = {}
        self._nonconforming: set[str] = set()

    def follow(self, event: e.Event) -> Left | None:
        """Take in the next event; returns the item that leaves the line with it."""
        if isinstance(event, e.OrderEvent):
            self._jobs[event.job] = Made(
                event.job, event.script, event.digest, event.recipe, event.recipe_version
            )
        elif isinstance(event, e.ItemNonconforming):
            self._nonconforming.add(event.item)
        elif isinstance(event, e.TaskContinued):
            if event.nonconforming is not None:
                self._nonconforming.add(event.nonconforming)
        elif isinstance(event, e.ItemRemoved):
            is_bad = event.item in self._nonconforming
            self._nonconforming.discard(event.item)
            return Left(self._jobs.get(event.job) or Made(event.job), event.how, is_bad)
        elif isinstance(event, (e.JobCompleted, e.JobAborted, e.JobRemoved)):
            self._jobs.pop(event.job, None)
        return None

    def plain(self) -> dict[str, Any]:
        """Return what it knows, as JSON carries it."""
        jobs = [to_plain(job) for job in self._jobs.values()]
        return {'jobs': jobs, 'nonconforming': sorted(self._nonconforming)}

    def go_on_from(self, plain: Mapping[str, Any]) -> None:
        """Know what another one knew."""
        self._jobs = {one['job']: from_plain(Made, one) for one in plain['jobs']}
        self._nonconforming = set(plain['nonconforming'])


def count(made: Made, left: Left) -> None:
    """Count an item."""
    kind = kind_of(left.how, is_nonconforming=left.is_bad)
    setattr(made, kind, getattr(made, kind) + 1)


def add(made: Made, more: Made, *, is_planned: bool) -> None:
    """Add what was made of the same job in another stretch of time."""
    if not is_planned:
        made.outside += more.produced + more.outside
        return
    made.good += more.good
    made.nonconforming += more.nonconforming
    made.rejected += more.rejected
    made.by_hand += more.by_hand
    made.outside += more.outside


FOLLOWED = (
    e.ItemNonconforming.event,
    e.TaskContinued.event,
    e.ItemRemoved.event,
)
