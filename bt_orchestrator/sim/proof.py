"""The proof that a script cannot get stuck: one virtual run of the compiled tree (semantics 8.2).

By 3.2, 4.1, 4.2 and 5.2 data never changes the flag and belt operations, durations only change
when and not whether, and every wait for a flag points to the same or an earlier item. So a run of
2·S items decides; docs/deadlock_proof.md has the argument and its conditions.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.codec import digest
from bt_orchestrator.model.order import Job
from bt_orchestrator.model.script import Dependency, Script
from bt_orchestrator.model.state import CellState
from bt_orchestrator.model.wait import WaitKind
from bt_orchestrator.ports import ActionTypes, EventStore, Objection
from bt_orchestrator.runtime.waits import PartWait
from bt_orchestrator.sim.reduction import reduced_cell, reduced_script
from bt_orchestrator.sim.simulation import Outcome, Simulation
from bt_orchestrator.sim.standstill import standstill

_JOB = 'proof'


@dataclass(frozen=True)
class Deadlock:
    """How a script gets stuck."""

    script: str
    item: int
    """The last item placed or begun when the circle closed, counted from 1."""
    beat: int
    circle: tuple[PartWait, ...]
    flags: tuple[str, ...]
    """Flags that someone in the circle waits for."""
    remedy: str
    """The smallest change of one flag that frees the line; empty: there is none up to S."""

    def __str__(self) -> str:
        waits = '; '.join(f'{wait.part} is {wait.reason}' for wait in self.circle)
        return (
            f'the line gets stuck with {self.script}, at item {self.item} in beat {self.beat}: '
            + re.sub(rf'\b{_JOB}/(\d+)', r'item \1', waits)
        )


class DeadlockProof:
    """Proves scripts for one cell, each script once. Implements `ports.AdmissionCheck`."""

    def __init__(
        self, cell: Cell, types: ActionTypes, make_store: Callable[[], EventStore]
    ) -> None:
        self._cell = reduced_cell(cell)
        self._types = types
        self._make_store = make_store
        self._known: dict[str, Deadlock | None] = {}

    def objection(self, script: Script) -> Objection | None:
        """Say why a script must not run on this cell; None: it may."""
        found = self.deadlock(script)
        if found is None:
            return None
        otherwise = 'no larger capacity or initial count of one flag frees it'
        return Objection(str(found), found.remedy or otherwise, found.flags)

    def deadlock(self, script: Script) -> Deadlock | None:
        """Return how a script gets stuck; None: it is proven that it cannot."""
        name = digest(script)
        if name not in self._known:
            self._known[name] = self._prove(script)
        return self._known[name]

    def _prove(self, script: Script) -> Deadlock | None:
        if not script.dependencies:
            return None  # nothing waits for anything but the belt, and the belt for what ends
        probe = reduced_script(script)
        found = self._run(probe)
        return None if found is None else replace(found, remedy=self._remedy(probe, found))

    def _run(self, script: Script) -> Deadlock | None:
        simulation = Simulation(self._cell, self._types, self._make_store())
        try:
            simulation.submit([Job(_JOB, script, 2 * self._cell.conveyor.sections)])
            outcome = simulation.run()
            if outcome is Outcome.FINISHED:
                return None
            circle = tuple(standstill(simulation.state, simulation.waits()))
            return _deadlock(script, simulation.state, circle)
        finally:
            simulation.close()

    def _remedy(self, script: Script, found: Deadlock) -> str:
        """Try larger capacities and initial counts of each flag in the circle."""
        for dependency in script.dependencies:
            if dependency.flag in found.flags:
                for one in _remedies(dependency, self._cell.conveyor.sections):
                    if self._run(_with(script, one)) is None:
                        return _in_words(one, dependency)
        return ''


def _remedies(dependency: Dependency, sections: int) -> Iterator[Dependency]:
    """Yield changed dependencies, the smallest change first, capacity before initial count."""
    for more in range(1, sections + 1):
        yield replace(dependency, capacity=dependency.capacity + more)
        initial = dependency.initial + more
        yield replace(dependency, initial=initial, capacity=max(dependency.capacity, initial))


def _with(script: Script, changed: Dependency) -> Script:
    dependencies = tuple(
        changed if one.flag == changed.flag else one for one in script.dependencies
    )
    return replace(script, dependencies=dependencies)


def _in_words(changed: Dependency, before: Dependency) -> str:
    flag = f'of flag {changed.flag} frees it'
    if changed.initial == before.initial:
        return f'capacity {changed.capacity} {flag}'
    if changed.capacity == before.capacity:
        return f'initial count {changed.initial} {flag}'
    return f'initial count {changed.initial} with capacity {changed.capacity} {flag}'


def _deadlock(script: Script, state: CellState, circle: tuple[PartWait, ...]) -> Deadlock:
    awaited = {one.wait.name for one in circle if one.wait.kind is WaitKind.FLAG}
    flags = tuple(d.flag for d in script.dependencies if d.flag in awaited)
    return Deadlock(
        script=script.name,
        item=state.jobs[_JOB].progress.started,
        beat=state.beat,
        circle=circle,
        flags=flags,
        remedy='',
    )
