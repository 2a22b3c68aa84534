"""The parts of the tree that share flags, zones and components, by the scripts in use."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from typing import NamedTuple

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.script import Script

Part = int | str
"""A section by its number; initialization or belt by name."""

INITIALIZATION: Part = 'initialization'
BELT: Part = 'belt'

Parts = int
"""A set of parts: the sum of their bits."""

_Uses = dict[tuple[str, str | int], Parts]
"""The parts that use a flag, zone or component, or have a list, by kind and name."""


class Concern(NamedTuple):
    """The parts that an event of a task affects."""

    all: Parts
    beside: Parts
    """Those that its start affects: the task's own leaf already shows it."""


class Sharing:
    """The places of tasks, zones and flags of the scripts in use, as scripts come and go.

    A part has a bit, whose place is that of the part in a tick.
    """

    def __init__(self, cell: Cell, bits: Mapping[Part, int]) -> None:
        """Begin with the belt alone."""
        self._bits = bits
        self._conveyor = cell.conveyor.component.name
        self._jobs: Counter[str] = Counter()
        """Number of jobs at work per script, by its digest."""
        self._scripts: dict[str, Script] = {}
        self._uses_of: dict[str, _Uses] = {}
        self._uses: _Uses = {}
        self.sources: frozenset[int] = frozenset()
        """The sections that begin items."""
        self.prepares = False
        """A script has an initialization."""
        self._put_together()

    def enter(self, digest: str, script: Script) -> None:
        """Add a job at work."""
        self._jobs[digest] += 1
        if digest not in self._scripts:
            self._scripts[digest], self._uses_of[digest] = script, uses_of(script, self._bits)
            self._put_together()

    def leave(self, digest: str) -> None:
        """Remove a job at work."""
        self._jobs[digest] -= 1
        if not self._jobs[digest]:
            del self._jobs[digest], self._scripts[digest], self._uses_of[digest]
            self._put_together()

    def flag(self, name: str) -> Parts:
        """Return where a flag is waited for or changed."""
        return self._uses.get(('flag', name), 0)

    def component(self, name: str) -> Parts:
        """Return where a component works."""
        return self._uses.get(('component', name), 0)

    def works(self, section: int) -> bool:
        """Tell whether a section has a list in any script."""
        return ('list', section) in self._uses

    def move(self) -> Concern:
        """Return the parts affected by the move of the belt: the belt and its component."""
        parts = self.component(self._conveyor)
        return Concern(parts, parts & ~self._bits[BELT])

    def task(self, digest: str, task: str) -> Concern | None:
        """Return the parts affected by a task of a section's list; None: possibly all."""
        script = self._scripts.get(digest)
        section = None if script is None else script.section_of(task)
        if script is None or not section:  # initialization may affect every section
            return None
        own = self._bits[section]
        parts = own | self.component(script.tasks[task].component)
        for zone in script.zones_of.get(task, ()):
            parts |= self._uses.get(('zone', zone), 0)
        return Concern(parts, parts if script.step_of(task).is_group else parts & ~own)

    def _put_together(self) -> None:
        self._uses = {('component', self._conveyor): self._bits[BELT]}
        for uses in self._uses_of.values():
            for use, parts in uses.items():
                self._uses[use] = self._uses.get(use, 0) | parts
        self.sources = frozenset(script.source for script in self._scripts.values())
        self.prepares = any(script.initialization for script in self._scripts.values())


def uses_of(script: Script, bits: Mapping[Part, int]) -> _Uses:
    """Return what a script uses where."""
    uses: _Uses = {}
    for use, part in _each_use(script):
        uses[use] = uses.get(use, 0) | bits[part]
    return uses


def _each_use(script: Script) -> Iterator[tuple[tuple[str, str | int], Part]]:
    for component, section in script.places_of_work:
        yield ('component', component), section or INITIALIZATION
    for zone in script.zones:
        for task in zone.tasks:
            yield ('zone', zone.name), script.section_of(task) or INITIALIZATION
    for dependency in script.dependencies:
        for end in (dependency.upstream, dependency.downstream):
            yield ('flag', dependency.flag), script.section_of(end) or INITIALIZATION
    for section in script.sections:
        yield ('list', section), section
