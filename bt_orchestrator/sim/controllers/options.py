"""The choice of simulated controllers: which components, which faults, how fast."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.model.cell import Cell, Component
from bt_orchestrator.model.uptime import Uptime
from bt_orchestrator.ports import ActionTypes, Clock, Timer
from bt_orchestrator.sim.faults import add_faults, unknown_component


class WrongSelection(OrchestratorError):
    """The choice on the command line does not fit the cell."""


def select(
    cell: Cell, only: Sequence[str], faults: Sequence[str], types: ActionTypes
) -> list[Component]:
    """Return the components to simulate, in the order of the cell file.

    :param only: names of components; none of them means all
    :param faults: as users write them, `COMPONENT.[TASK][#NTH]=KIND[:SECONDS]`; they add to those
        of the cell file
    :raises WrongSelection: with everything that is wrong, one mistake a line
    """
    mistakes = [
        f'--only {name}: {unknown_component(name, cell)}'
        for name in only
        if name not in cell.components
    ]
    chosen = {name: c for name, c in cell.components.items() if not only or name in only}
    mistakes += add_faults(chosen, cell, faults, types)
    if mistakes:
        raise WrongSelection('\n'.join(mistakes))
    return list(chosen.values())


def controller_names(texts: Sequence[str]) -> Iterator[str]:
    """Yield the names in comma-separated lists."""
    return (name.strip() for text in texts for name in text.split(',') if name.strip())


# How fast simulated controllers run.


@dataclass(frozen=True)
class Pace:
    """How fast the simulated cell runs."""

    speed: float = 1.0
    """All simulated seconds, those of faults too, are divided by this."""
    feedback_s: float = 0.5
    """Real seconds between two feedback messages of a goal; 0: only the one at its start."""


class PacedClock:
    """A clock that runs faster or slower than another. Implements `ports.Clock`.

    `now()` stays what it is: records are compared with those of other programs.
    """

    def __init__(self, clock: Clock, speed: float) -> None:
        self._clock = clock
        self._speed = speed

    def now(self) -> float:
        """Return the other clock's time."""
        return self._clock.now()

    def steady(self) -> float:
        """Return steady seconds of this clock."""
        return self._clock.steady() * self._speed

    def uptime(self) -> Uptime | None:
        """Return the other clock's."""
        return self._clock.uptime()

    def call_at(self, time: float, callback: Callable[[], None]) -> Timer:
        """Call back once `steady()` has reached a time."""
        return self._clock.call_at(time / self._speed, callback)
