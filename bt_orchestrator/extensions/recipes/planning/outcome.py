"""The outcome of planning: a script with its facts, or the reason why there is no script."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Protocol

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.model.proof.pace import Pace
from bt_orchestrator.model.script import Script


class Judge(Protocol):
    """Runs a script, to see how fast it really is where sections share something."""

    def pace_s(self, script: Script) -> float | None:
        """Return the seconds from one item to the next; None: the line does not get so far."""


@dataclass(frozen=True)
class Limits:
    """How much is tried. Counts, never times: equal inputs give equal scripts."""

    nodes: int = 1_000
    """Of the tree that the solver may search for the pace; the other stages get less."""
    question_nodes: int = 5_000
    """The same for each question that goes on where this has proven no pace; 0: nothing does.

    In steps it is twice as many.
    """
    finalists: int = 16
    """Plans that are run by the engine where sections share something."""


LIMITS = Limits()

SAME_S = 1e-6
"""Times that differ by less are equal."""


class Why(Enum):
    """Why a component does an operation, or why there; the first that holds."""

    OVERRIDE = 'bound by override'
    ONLY = 'the only one that can'
    KEPT = 'as before'
    PACE = 'any other makes the line slower'
    SPREAD = 'spreads the load best'
    EQUAL = 'as good as others'
    FOUND = 'in the best plan that was found'


@dataclass(frozen=True)
class Made:
    """Where a task came from."""

    operation: str
    """Its id in the recipe; of initialization the id of the preparation."""
    capability: str
    """Empty: it prepares its component."""
    component: str
    section: int
    """0: initialization."""
    why: Why
    alternatives: tuple[str, ...] = ()
    """Other components that could do it."""


@dataclass(frozen=True)
class Claim:
    """How fast the script is, and how sure it is that no other one is faster."""

    pace: Pace
    """In closed form."""
    judged_s: float | None = None
    """Seconds for each item by the engine, where sections share something."""
    bound_s: float | None = None
    """No other binding takes less time for each item; None: this is not known."""
    spread_s: float = 0.0
    """Work of all sections; what is above an even share counts twice."""

    @property
    def per_item_s(self) -> float:
        """Seconds from one item to the next."""
        return self.pace.per_item_s if self.judged_s is None else self.judged_s

    @property
    def is_fastest(self) -> bool:
        """Tell whether it is proven that no other binding is faster."""
        return self.gap == 0

    @property
    def gap(self) -> float | None:
        """By which part of its time another binding may be faster; None: this is not known."""
        if self.bound_s is None:
            return None
        shorter_s = self.per_item_s - self.bound_s
        return shorter_s / self.per_item_s if shorter_s > SAME_S else 0.0

    def __str__(self) -> str:
        return f'{self.per_item_s:.1f} s for each item, {self._sure}'

    @property
    def _sure(self) -> str:
        if self.gap is None:
            return 'not proven to be the fastest'
        if not self.gap:
            return 'proven fastest'
        percent = math.ceil(self.gap * 1000) / 10
        return f'within {percent:.1f} % of the fastest: at least {self.bound_s:.1f} s'


@dataclass(frozen=True)
class Generated:
    """A script, and what is known of it."""

    script: Script
    made: Mapping[str, Made]
    """By task id, initialization included."""
    claim: Claim


@dataclass(frozen=True)
class Price:
    """The price of doing one operation with another component."""

    component: str
    more_s: float = 0.0
    """Seconds for each item, more than now."""
    at_least_s: float = 0.0
    """The same, as far as it is proven."""
    spread_s: float = 0.0
    """Where the pace is the same: how much worse the spread is."""
    is_least: bool = True
    """It is proven that the spread is no better."""
    reasons: tuple[str, ...] = ()
    """Why there is no such script."""
    is_impossible: bool = False

    @property
    def words(self) -> str:
        """Say it, as `+0.4 s`."""
        if self.reasons:
            verdict = 'impossible' if self.is_impossible else 'not known'
            return f'{verdict}: {"; ".join(self.reasons)}'
        if self.more_s > SAME_S:
            return self._slower
        if self.more_s < -SAME_S:
            return f'{-self.more_s:.3g} s faster'
        if abs(self.spread_s) <= SAME_S:
            return 'as good'
        worse = 'worse' if self.spread_s > 0 else 'better'
        at_most = '' if self.is_least or self.spread_s < 0 else 'at most '
        return f'same pace, spread {at_most}{abs(self.spread_s):.3g} s {worse}'

    @property
    def _slower(self) -> str:
        if self.at_least_s >= self.more_s - SAME_S:
            return f'+{self.more_s:.3g} s'
        if self.at_least_s > SAME_S:
            return f'+{self.at_least_s:.3g} to +{self.more_s:.3g} s'
        return f'at most +{self.more_s:.3g} s'


class NotMade(OrchestratorError):
    """There is no script for a recipe and a cell; each reason says why, in words."""

    def __init__(self, reasons: Sequence[str]) -> None:
        self.reasons = tuple(reasons)
        super().__init__('; '.join(self.reasons))

    def __reduce__(self) -> tuple[type[NotMade], tuple[Sequence[str]]]:
        """Make it picklable: by default an exception is rebuilt from its text alone."""
        return type(self), (self.reasons,)


class Impossible(NotMade):
    """It is proven that this cell cannot make the recipe."""


class NotFound(NotMade):
    """No script was found within the limits; that there is none is not proven."""
