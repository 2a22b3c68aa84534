"""The sections that an initialization task waits for, and that wait for it (semantics 5.2)."""

from __future__ import annotations

from collections.abc import Mapping

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.script import Script, Task


class Preparation:
    """The initialization of one script in one cell, worked out once."""

    def __init__(self, script: Script, cell: Cell) -> None:
        every = tuple(range(1, cell.conveyor.sections + 1))
        tasks = script.initialization
        self.sections: Mapping[str, tuple[int, ...]] = {
            task.id: cell.components[task.component].sections or every for task in tasks
        }
        """Sections of each task's component; all of them for a component of no section. They must
        be done with all earlier jobs before it starts, and wait for it before they begin."""
        self.upstream: Mapping[str, tuple[str, ...]] = {
            task.id: tuple(
                dependency.upstream
                for dependency in script.initialization_dependencies
                if dependency.downstream == task.id
            )
            for task in tasks
        }
        """Tasks that must have succeeded before each task starts."""
        self.of_section: Mapping[int, tuple[Task, ...]] = {
            s: tuple(task for task in tasks if s in self.sections[task.id]) for s in every
        }
        """Tasks for a section's own components, and for those of no section."""
        self._needed = {s: self._needed_by(s, script) for s in every}

    def needed_by(self, section: int) -> tuple[Task, ...]:
        """Return the tasks that must have succeeded before a section begins the job."""
        return self._needed[section]

    def _needed_by(self, section: int, script: Script) -> tuple[Task, ...]:
        return tuple(
            task
            for task in script.initialization
            if task in self.of_section[section]
            or (section == script.source and self._waits_downstream(task.id))
        )

    def _waits_downstream(self, task: str) -> bool:
        """Tell whether it waits, itself or through others, for a section behind one it counts for.

        An item could otherwise wait for a section that waits for the line behind it (5.2).
        """
        first = min(self.sections[task])
        return any(max(self.sections[t]) > first for t in (task, *self._ancestors(task)))

    def _ancestors(self, task: str) -> set[str]:
        ancestors: set[str] = set()
        pending = list(self.upstream[task])
        while pending:
            ancestor = pending.pop()
            if ancestor not in ancestors:
                ancestors.add(ancestor)
                pending.extend(self.upstream[ancestor])
        return ancestors
