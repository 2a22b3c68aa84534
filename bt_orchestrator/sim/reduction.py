"""A script with everything left out that cannot make a line stuck (docs/deadlock_proof.md).

What stays: every task that a flag or the belt's balance depends on, in its place among the steps,
and for each run of other steps between them one that stands for it. Sections with neither only
take time, and are left out whole. So are initialization, zones, conditions, arguments and failure
policies: none of them changes the order in which flags and belt are used.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import groupby

from bt_orchestrator.model.cell import Cell, OnFailure
from bt_orchestrator.model.script import Script, SectionList, Step, Task


def without_faults(cell: Cell) -> Cell:
    """Return the cell with no component at fault."""
    components = {name: replace(one, faults=()) for name, one in cell.components.items()}
    conveyor = replace(cell.conveyor, component=components[cell.conveyor.component.name])
    return replace(cell, conveyor=conveyor, components=components)


def reduced_cell(cell: Cell) -> Cell:
    """Return the cell with every component always ready and never at fault."""
    components = {
        name: replace(component, state=None, faults=(), results={})
        for name, component in cell.components.items()
    }
    conveyor = replace(cell.conveyor, component=components[cell.conveyor.component.name])
    return replace(cell, conveyor=conveyor, components=components)


def reduced_script(script: Script) -> Script:
    """Return the script with only what can make a line stuck."""
    flagged = {*script.upstream_of, *script.downstream_of}
    lists = (_reduced_list(tasks, flagged) for tasks in script.sections.values())
    return replace(
        script,
        sections={tasks.section: tasks for tasks in lists if tasks is not None},
        initialization=(),
        initialization_dependencies=(),
        zones=(),
        params={},
    )


def _reduced_list(tasks: SectionList, flagged: set[str]) -> SectionList | None:
    if not any(_matters(step, flagged) for step in tasks.steps):
        return None
    steps: list[Step] = []
    for matters, group in groupby(tasks.steps, key=lambda step: _matters(step, flagged)):
        run = list(group)
        steps.extend(map(_plain, run) if matters else _stand_ins(run))
    return replace(tasks, steps=tuple(steps))


def _stand_ins(run: list[Step]) -> Iterator[Step]:
    """Yield what stands for a run of steps: its first, and the first and last on the conveyor.

    Whether the first may run ahead (semantics 3.7) and which is the last before the turn is
    complete (3.8) stay as they are.
    """
    needing = [step for step in run if step.requires_conveyor]
    kept = [run[0], *needing[:1], *needing[-1:], run[-1]]
    for step in dict.fromkeys(map(id, kept)):
        one = next(s for s in kept if id(s) == step)
        first = replace(next(one.tasks), requires_conveyor=one.requires_conveyor)
        yield Step(((_bare(first),),))


def _plain(step: Step) -> Step:
    return Step(tuple(tuple(map(_bare, track)) for track in step.tracks))


def _bare(task: Task) -> Task:
    return replace(
        task, args={}, condition=None, on_failure=OnFailure.HOLD, retries=0, timeout_s=None
    )


def _matters(step: Step, flagged: set[str]) -> bool:
    return any(task.id in flagged or task.qty_change for task in step.tasks)
