"""How fast a script is by the engine itself, for plans in which sections share something."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.jobs.order import Job
from bt_orchestrator.model.script import RunsFor, Script, SectionList, Step, Task
from bt_orchestrator.ports import ActionTypes, EventStore
from bt_orchestrator.sim.simulation import Outcome, Simulation

ITEMS = 24
"""Beside those that fill the line: a line with shared spaces need not repeat itself at once."""


class PaceJudge:
    """Runs scripts in virtual time with good items only. Implements `planning.Judge`."""

    def __init__(
        self, cell: Cell, types: ActionTypes, new_store: Callable[[], EventStore]
    ) -> None:
        """Judge scripts of a cell.

        :param new_store: makes an empty store, for each run
        """
        components = {name: replace(one, faults=()) for name, one in cell.components.items()}
        conveyor = replace(cell.conveyor, component=components[cell.conveyor.component.name])
        self._cell = replace(cell, conveyor=conveyor, components=components)
        self._types = types
        self._new_store = new_store

    def pace_s(self, script: Script) -> float | None:
        """Return the seconds from one item to the next; None: the line does not get so far."""
        script = _with_good_items(script)
        fill = script.sink - script.source + 1
        packed = _Packed()
        simulation = Simulation(self._cell, self._types, self._new_store(), [packed])
        simulation.submit([Job('J', script, fill + ITEMS, {})])
        outcome = simulation.run()
        simulation.close()
        if outcome is not Outcome.FINISHED:
            return None
        times_s = packed.times_s[: ITEMS + 1]  # no more items come when the others leave
        half = len(times_s) // 2
        return (times_s[-1] - times_s[half]) / (len(times_s) - 1 - half)


class _Packed:
    """When items left. Implements `ports.EventSink`."""

    def __init__(self) -> None:
        self.times_s: list[float] = []

    def publish(self, events: Sequence[e.Event]) -> None:
        """Note it."""
        self.times_s += [one.time for one in events if isinstance(one, e.ItemRemoved)]


def _with_good_items(script: Script) -> Script:
    """Return a script in which every task for good items runs, and succeeds."""
    return replace(
        script,
        sections={number: _section(one) for number, one in script.sections.items()},
        initialization=(),
        initialization_dependencies=(),
        params={},
    )


def _section(section: SectionList) -> SectionList:
    return replace(section, steps=tuple(_step(step) for step in section.steps))


def _step(step: Step) -> Step:
    return replace(step, tracks=tuple(tuple(map(_task, track)) for track in step.tracks))


def _task(task: Task) -> Task:
    # Nobody rejects an item here; a task for rejected ones is skipped.
    runs_for = RunsFor.REJECTED if task.runs_for is RunsFor.REJECTED else RunsFor.GOOD
    return replace(
        task, args={}, condition=None, fails_unless=None, identifies=(), runs_for=runs_for
    )
