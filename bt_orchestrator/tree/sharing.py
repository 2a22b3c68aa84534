"""Which parts of the tree share flags, zones and components, by the scripts in use."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Collection, Iterator, Mapping
from typing import NamedTuple

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.script import Script

Part = int | str
"""A section by its number; initialization or belt by name."""

INITIALIZATION: Part = 'initialization'
BELT: Part = 'belt'

_Places = Collection[int]
_NOWHERE: _Places = ()


class _Use(NamedTuple):
    """The use of a shared resource by a script at a place."""

    kind: str
    name: str | int
    place: int
    times: int = 1


class Sharing:
    """What each script in use uses where, counted, as scripts come and go.

    Places are positions of parts in a tick, from 0.
    """

    def __init__(self, cell: Cell, place: Mapping[Part, int]) -> None:
        """Begin with the belt alone."""
        self._place = place
        self._conveyor = cell.conveyor.component.name
        self._uses: dict[tuple[str, str | int], Counter[int]] = defaultdict(Counter)
        self._jobs: Counter[str] = Counter()
        """Number of jobs at work per script, by its digest."""
        self._scripts: dict[str, Script] = {}
        self._concerned: dict[tuple[str, str], tuple[set[int], set[int]]] = {}
        """Cache by digest and task; cleared when a script comes or goes."""
        self._uses['component', self._conveyor][place[BELT]] += 1
        self.ends: tuple[int, ...] = ()
        """Places of the parts that check the whole line: ends of jobs, ends of turns."""
        self._find_ends()

    def enter(self, digest: str, script: Script) -> None:
        """Add a job at work."""
        self._jobs[digest] += 1
        if digest not in self._scripts:
            self._scripts[digest] = script
            self._count(script, 1)

    def leave(self, digest: str) -> None:
        """Remove a job at work."""
        self._jobs[digest] -= 1
        if not self._jobs[digest]:
            del self._jobs[digest]
            self._count(self._scripts.pop(digest), -1)

    def flag(self, name: str) -> _Places:
        """Return where a flag is waited for or changed."""
        return self._uses.get(('flag', name), _NOWHERE)

    def component(self, name: str) -> _Places:
        """Return where a component works."""
        return self._uses.get(('component', name), _NOWHERE)

    def works(self, section: int) -> bool:
        """Tell whether a section has a list in any script."""
        return ('list', section) in self._uses

    def move(self) -> _Places:
        """Return the places affected by the move of the belt: the belt and its component."""
        return self.component(self._conveyor)

    def beside_move(self) -> _Places:
        """Return the same without the belt itself."""
        return set(self.move()) - {self._place[BELT]}

    def task(self, digest: str, task: str) -> _Places | None:
        """Return the places affected by a task of a section's list; None: possibly all."""
        found = self._find(digest, task)
        return None if found is None else found[0]

    def beside_task(self, digest: str, task: str) -> _Places | None:
        """Return the same without the section itself, if nothing there runs in parallel."""
        found = self._find(digest, task)
        return None if found is None else found[1]

    def _find(self, digest: str, task: str) -> tuple[set[int], set[int]] | None:
        found = self._concerned.get((digest, task))
        if found is None and digest in self._scripts:
            script = self._scripts[digest]
            section = script.section_of(task)
            if section:  # initialization may affect every section
                found = self._concerned[digest, task] = self._places_of(script, section, task)
        return found

    def _places_of(self, script: Script, section: int, task: str) -> tuple[set[int], set[int]]:
        own = {self._place[section]}
        zones = (self._uses['zone', zone] for zone in script.zones_of.get(task, ()))
        places = own.union(self.component(script.tasks[task].component), *zones)
        return places, places if script.step_of(task).is_group else places - own

    def _count(self, script: Script, number: int) -> None:
        for use in _uses_of(script, self._place):
            places = self._uses[use.kind, use.name]
            places[use.place] += number * use.times
            if not places[use.place]:
                del places[use.place]
            if not places:
                del self._uses[use.kind, use.name]
        self._concerned.clear()
        self._find_ends()

    def _find_ends(self) -> None:
        sources = {script.source for script in self._scripts.values()}
        self.ends = tuple(self._place[part] for part in (INITIALIZATION, *sources, BELT))


def _uses_of(script: Script, place: Mapping[Part, int]) -> Iterator[_Use]:
    for (component, section), times in script.places_of_work.items():
        yield _Use('component', component, place[section or INITIALIZATION], times)
    for zone in script.zones:
        for task in zone.tasks:
            at = place[script.section_of(task) or INITIALIZATION]
            yield _Use('zone', zone.name, at)
    for dependency in script.dependencies:
        for end in (dependency.upstream, dependency.downstream):
            yield _Use('flag', dependency.flag, place[script.section_of(end)])
    yield from (_Use('list', section, place[section]) for section in script.sections)
