"""How fast a line really is: a run of the engine in virtual time, once the line is full."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from fakes.action_types import FakeActionTypes
from fakes.virtual_run import defaults

from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.script import Script
from bt_orchestrator.sim.simulation import Outcome, Simulation
from bt_orchestrator.store.memory import MemoryStore

TYPES = FakeActionTypes()
LONGEST_PERIOD = 12
"""Items after which everything repeats in a line without shared spaces of so few sections."""
LOOKED_AT = 24
"""Items at the end of a run in which everything has to repeat."""


class Steady(NamedTuple):
    """What the end of a run says."""

    per_item_s: float
    repeats: bool
    """It does the same again and again; else the line still changes, and this is a mean."""


class _Packed:
    """Remembers when items are packed. Implements `ports.EventSink`."""

    def __init__(self) -> None:
        self.times_s: list[float] = []
        self.all_good = True

    def publish(self, events: Sequence[e.Event]) -> None:
        for event in events:
            if isinstance(event, e.ItemRemoved):
                self.times_s.append(event.time)
            elif isinstance(event, (e.ItemRejected, e.TaskFailed)):
                self.all_good = False


def steady(cell: Cell, script: Script, items: int = 60, *, at_most: int = 480) -> Steady | None:
    """Run a job of one script with the nominal durations; None: it does not end, or a task fails.

    A line that has not come to its pace by then is run for much longer.

    :param at_most: items; a line with shared spaces may never come to a pace that repeats
    """
    packed = _Packed()
    simulation = Simulation(cell, TYPES, MemoryStore(), [packed])
    simulation.submit([Job('J', script, items, defaults(script))])
    outcome = simulation.run()
    simulation.close()
    if outcome is not Outcome.FINISHED or not packed.all_good:
        return None
    pace = _of(packed.times_s[: items - script.sink + script.source])
    if pace.repeats or items >= at_most:
        return pace
    return steady(cell, script, at_most, at_most=at_most)


def _of(times_s: Sequence[float]) -> Steady:
    """Look at the items that leave while others still come."""
    last = len(times_s) - 1
    for period in range(1, LONGEST_PERIOD + 1):
        took_s = times_s[last] - times_s[last - period]
        late = range(last - LOOKED_AT, last)
        if all(abs(times_s[n] - times_s[n - period] - took_s) < 1e-6 for n in late):
            return Steady(took_s / period, repeats=True)
    half = last // 2
    return Steady((times_s[last] - times_s[half]) / (last - half), repeats=False)
