"""What is shot at, in which order, and how an orchestrator is started after it."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Mapping, Sequence
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

STRIKES = {
    'cut': 'the connections of the orchestrator end',
    'restart': 'the server ends connections, and is started again',
    'crash': 'the server ends at once, as after a crash, and is started again',
    'lost_answer': 'the answer to a commit is lost',
    'lost_commit': 'the server answers a statement, and loses its commit',
    'promotion': 'the server is gone for good, and its synchronous replica takes its place',
}
"""What becomes of the database of a journal."""

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
    """A crash point, `ORCHESTRATOR`, `BOTH`, a share of the controllers, or one of `STRIKES`."""

    target: str
    restart: Restart = Restart()
    stopped_s: float = 0.0
    """An orchestrator that is only stopped goes on after that; 0: it is killed."""

    @property
    def kills(self) -> bool:
        """Tell whether an orchestrator is started anew after it."""
        return self.target not in (*SHARES, *STRIKES) and not self.stopped_s


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


_STOPPED_S = (0.1, 7.0)
"""How long an orchestrator is stopped: some longer than its database, or its servers, wait."""


def draw_with_database(
    drawn: random.Random, kills: int, stops: int, strikes: Mapping[str, int]
) -> Iterator[Shot]:
    """Yield so many shots of each kind at an orchestrator and its database, in any order.

    :param strikes: how many of each of `STRIKES`
    """
    points, resumes = _Bag(drawn, (*POINTS, ORCHESTRATOR)), _Bag(drawn, _AUTO_RESUME)
    shots = [Shot(points.take(), Restart(auto_resume=resumes.take())) for _ in range(kills)]
    points = _Bag(drawn, tuple(POINTS))
    shots += [Shot(points.take(), stopped_s=drawn.uniform(*_STOPPED_S)) for _ in range(stops)]
    shots += [Shot(strike) for strike, number in strikes.items() for _ in range(number)]
    drawn.shuffle(shots)
    yield from shots


def parts(shots: Sequence[Shot], kills: int) -> Iterator[list[Shot]]:
    """Yield shots in parts with so many at orchestrators each."""
    part: list[Shot] = []
    for shot in shots:
        if sum(each.target not in SHARES for each in part) == kills and shot.target not in SHARES:
            yield part
            part = []
        part.append(shot)
    if part:
        yield part
