"""The output, by job."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from bt_orchestrator.model.jobs.counting import GOOD
from bt_orchestrator.view.report.account.causes.flaws import Bounds, Effect, Flaw


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
    first_pass: int = 0
    """Good ones for which nothing was done again and nothing was let pass."""
    attempts: int = 0
    """Further attempts of tasks of its items."""
    rounds: int = 0
    """Further rounds of repeats."""

    @property
    def product(self) -> str:
        """The recipe; of a script that was written by hand its name."""
        return self.recipe or self.script or self.job

    @property
    def produced(self) -> int:
        """All that were made in planned time (ISO 22400: produced quantity)."""
        return self.good + self.bad

    @property
    def bad(self) -> int:
        """Those that are not good."""
        return self.nonconforming + self.rejected + self.by_hand


class Left(NamedTuple):
    """An item that left the line."""

    of: Made
    """Its job, with no counts."""
    kind: str
    """Good, nonconforming, rejected or by hand."""
    is_first_pass: bool
    flaw: Flaw | None
    """Why it is not good; None: it is."""


class Again(NamedTuple):
    """Something was done once more for an item."""

    of: Made
    """Its job, with no counts."""
    flaw: Flaw


class Measured(NamedTuple):
    """A value was measured."""

    of: Bounds
    value: float


Happening = Left | Again | Measured


def count(made: Made, what: Left | Again) -> None:
    """Count an item that left, or what was done again."""
    if isinstance(what, Again):
        made.rounds += what.flaw.effect is Effect.ROUND
        made.attempts += what.flaw.effect is Effect.ATTEMPT
        return
    setattr(made, what.kind, getattr(made, what.kind) + 1)
    made.first_pass += what.kind == GOOD and what.is_first_pass


def add(made: Made, more: Made, *, is_planned: bool) -> None:
    """Add what was made of the same job in another stretch of time."""
    if not is_planned:
        made.outside += more.produced + more.outside
        return
    for name in _COUNTS:
        setattr(made, name, getattr(made, name) + getattr(more, name))


_COUNTS = (
    'good',
    'nonconforming',
    'rejected',
    'by_hand',
    'outside',
    'first_pass',
    'attempts',
    'rounds',
)
