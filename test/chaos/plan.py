"""What is shot at, in which order, and how an orchestrator is started after it."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

from chaos.crashing_node import POINTS
from chaos.line import REMEMBERED_S

_T = TypeVar('_T')

ORCHESTRATOR = 'orchestrator'
"""At a random moment."""

SHARES = ('feeder,conveyor', 'camera,worker,packer')
"""What each process of controllers simulates."""

BOTH = 'both'
"""The orchestrator, and controllers with it."""

_CONTROLLERS_EVERY = 5
"""One shot in so many is at controllers, on top of those at the orchestrator."""

_WITH_CONTROLLERS = (*SHARES, BOTH, BOTH)
"""What such a shot is at, each as likely."""

_AT_RANDOM = 3
"""Random moments among the crash points, so often as each of them."""


@dataclass(frozen=True)
class Restart:
    """How the next orchestrator is started."""

    away_s: float = 0.0
    """How long nobody runs the cell before."""
    clock_step_s: float = 0.0
    """How far the clock of the orchestrator's computer is set meanwhile; below 0: back."""
    auto_resume: bool = True
    """False: it waits for an operator who names the hold."""


@dataclass(frozen=True)
class Shot:
    """What is killed: a crash point, `ORCHESTRATOR`, `BOTH`, or a share of the controllers."""

    target: str
    restart: Restart = Restart()


def forgotten(drawn: random.Random) -> Restart:
    """Return a start after the servers forgot what ended, by a clock that says they did not.

    A proof that a goal never arrived must not believe that clock (semantics 9.2).
    """
    away_s = REMEMBERED_S + drawn.uniform(0.5, 1.5)
    return Restart(away_s, -away_s - drawn.uniform(2.0, 4.0))


_CLOCKS: tuple[Callable[[random.Random], Restart], ...] = (
    forgotten,
    lambda drawn: Restart(clock_step_s=-drawn.uniform(1.0, 20.0)),
    lambda drawn: Restart(clock_step_s=-drawn.uniform(60.0, 300.0)),
    lambda drawn: Restart(clock_step_s=drawn.uniform(1.0, 90.0)),
    *[lambda _: Restart()] * 4,
)
"""What happens to the clock, each as likely."""

_AUTO_RESUME = (True, True, False)


class _Bag(Generic[_T]):
    """Gives each of its things once before any of them again."""

    def __init__(self, drawn: random.Random, things: Sequence[_T]) -> None:
        self._drawn = drawn
        self._things = things
        self._left: list[_T] = []

    def take(self) -> _T:
        """Return the next one."""
        self._left = self._left or self._drawn.sample(self._things, len(self._things))
        return self._left.pop()


def draw(drawn: random.Random, kills: int) -> Iterator[Shot]:
    """Yield so many shots at orchestrators, each point in its turn, and at controllers between."""
    targets, clocks = _Bag(drawn, (*POINTS, *[ORCHESTRATOR] * _AT_RANDOM)), _Bag(drawn, _CLOCKS)
    resumes = _Bag(drawn, _AUTO_RESUME)
    for number in range(1, kills + 1):
        clock = clocks.take()(drawn)
        yield Shot(targets.take(), Restart(clock.away_s, clock.clock_step_s, resumes.take()))
        if number % _CONTROLLERS_EVERY == 0:
            yield Shot(drawn.choice(_WITH_CONTROLLERS))


def parts(shots: Sequence[Shot], kills: int) -> Iterator[list[Shot]]:
    """Yield shots in parts with so many at orchestrators each."""
    part: list[Shot] = []
    for shot in shots:
        if sum(one.target not in SHARES for one in part) == kills and shot.target not in SHARES:
            yield part
            part = []
        part.append(shot)
    if part:
        yield part
