"""Which parts of the tree an event can concern: the others need no tick.

A part that is not ticked keeps its status and its words, as if it had been ticked and found
everything as before. So a part may be left out only if no event since its last tick touches
anything it reads; when in doubt, everything is ticked.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator

from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status
from py_trees.composites import Parallel

from bt_orchestrator.model import events as e
from bt_orchestrator.model.state import CellState

Part = int | str
"""A section by its number, or one of the two others by name."""

_CHANGE_SCRIPTS = (e.JobQueued, e.JobUpdated, e.JobRemoved, e.JobCompleted, e.JobAborted)

INITIALIZATION: Part = 'initialization'
BELT: Part = 'belt'


class Attention:
    """The parts that the next tick has to look at."""

    def __init__(self, state: CellState) -> None:
        self._state = state
        self._all: tuple[Part, ...] = (INITIALIZATION, *state.sections, BELT)
        self._due: set[Part] = set(self._all)
        self._index()

    def take(self, part: Part) -> bool:
        """Tell whether a part is due, and consider it seen."""
        if part not in self._due:
            return False
        self._due.remove(part)
        return True

    def everywhere(self) -> None:
        """Look at every part again: time has come for something, or a tick was cut short."""
        self._due.update(self._all)

    def notice(self, event: e.Event) -> None:
        """Take note of an event that was applied to the state."""
        if isinstance(event, _CHANGE_SCRIPTS):
            self._index()
        if isinstance(event, e.FlagEvent):
            self._due |= self._flags[event.flag]
        elif isinstance(event, e.TaskEvent):
            self._task(event)
        elif isinstance(event, e.CycleEvent):
            self._due |= {event.section, BELT, INITIALIZATION, *self._sources}
        elif isinstance(event, e.ComponentStateChanged):
            self._due |= self._components[event.component]
        else:
            self.everywhere()

    def _task(self, event: e.TaskEvent) -> None:
        task = self._state.task(event.key)
        if event.section is None or task is None:
            self.everywhere()
            return
        self._due.add(event.section)
        self._due |= self._components[task.component]
        for zone in self._state.script(event.key.job or '').zones_of.get(task.id, ()):
            self._due |= self._zones[zone]

    def _index(self) -> None:
        """Work out which parts share flags, zones and components, for the live jobs."""
        self._flags: dict[str, set[Part]] = defaultdict(set)
        self._zones: dict[str, set[Part]] = defaultdict(set)
        self._components: dict[str, set[Part]] = defaultdict(set)
        scripts = self._state.scripts.values()
        self._sources = {script.source for script in scripts}
        for script in scripts:
            for task in script.tasks.values():
                part = script.section_of(task.id) or INITIALIZATION
                self._components[task.component].add(part)
                for zone in script.zones_of.get(task.id, ()):
                    self._zones[zone].add(part)
            for dependency in script.dependencies:
                ends = (dependency.upstream, dependency.downstream)
                self._flags[dependency.flag].update(map(script.section_of, ends))
        self._components[self._state.cell.conveyor.component.name].add(BELT)


class CellRoot(Parallel):
    """The root: a parallel that never ends, and that ticks the parts that are due."""

    def __init__(
        self, name: str, parts: Iterable[tuple[Part, Behaviour]], attention: Attention
    ) -> None:
        self._parts = list(parts)
        self._attention = attention
        children = [behaviour for _, behaviour in self._parts]
        super().__init__(name, ParallelPolicy.SuccessOnAll(synchronise=False), children)

    def tick(self) -> Iterator[Behaviour]:
        """Tick the parts that are due, in order."""
        for part, behaviour in self._parts:
            if self._attention.take(part):
                yield from behaviour.tick()
        self.current_child = self.children[-1]
        self.status = Status.RUNNING
        yield self
