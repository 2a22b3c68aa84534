"""The operations of a line and their order relations: one graph, of one script or of several.

docs/deadlock_proof.md says why these relations decide.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from copy import copy
from itertools import product
from typing import NamedTuple

from bt_orchestrator.model.script import Dependency, Script, SectionList, Step, Task


class Precedence:
    """Operations, and the relations between them."""

    def __init__(self, scripts: Sequence[Operations]) -> None:
        """Relate scripts whose items may follow each other in any order.

        Scripts that share a flag have the same counts for it (semantics 4.1).
        """
        self.operations = [operation for script in scripts for operation in script.all]
        self.turns = [turn for script in scripts for turn in script.turns.values()]
        self.first = min(script.source for script in scripts)
        """The first section with work."""
        self.length = max(script.sink for script in scripts) - self.first
        """Number of moves from there to the last section with work."""
        self.after: Mapping[Operation, list[Relation]] = defaultdict(list)
        """By operation: the relations to what must come later."""
        self.before: Mapping[Operation, list[Relation]] = defaultdict(list)
        """By operation: the relations to what must come earlier."""
        lists = (relation for script in scripts for relation in script.order)
        for relation in (*lists, *_of_cycles(scripts), *_of_flags(scripts)):
            self.after[relation.before].append(relation)
            self.before[relation.after].append(relation)

    def beat(self, operation: Operation, item: int) -> int:
        """Return the beat of an operation for an item, if an item is begun in every beat."""
        return item + operation.section - self.first

    def item(self, operation: Operation, beat: int) -> int:
        """Return the item of an operation in a beat; below 1 there is none yet."""
        return beat - operation.section + self.first


def _of_cycles(scripts: Sequence[Operations]) -> Iterator[Relation]:
    """Yield the relations that a section ends each cycle before it begins the next."""
    for script, following in product(scripts, repeat=2):
        for section, end in script.ends.items():
            if section in following.begins:
                yield Relation(end, following.begins[section], 1)


def _of_flags(scripts: Sequence[Operations]) -> Iterator[Relation]:
    """Yield the relations of flags: adding needs room, taking needs a count (semantics 4.1).

    All but `capacity` of the initial and added counts must be taken before the next addition; the
    first `initial` takings need no addition. Each item belongs to one script.
    """
    shared = [
        (script, other, flag)
        for script, other in product(scripts, repeat=2)
        for flag in script.flags
        if flag in other.flags
    ]
    for script, other, flag in shared:
        wants, taking = script.flags[flag], other.flags[flag].downstream
        room = wants.capacity - wants.initial
        if room or script is other:
            up = script.of_task[wants.upstream]
            yield Relation(other.of_task[taking], up, room, (taking,), wants)
    for script, other, flag in shared:
        wants, adding = script.flags[flag], other.flags[flag].upstream
        if wants.initial or script is other:
            down = script.of_task[wants.downstream]
            yield Relation(other.of_task[adding], down, wants.initial, (adding,), wants)


# The operations of one script; each one represents that operation for every item.
#
# Only what another section can wait for is an operation: tasks with flags, and their relations to
# the belt. Everything else in a list takes time, and always ends: it stands in a relation.


class Operation(NamedTuple):
    """Something that a section does once for every item; its moment is when it begins."""

    number: int
    """Unique; ascending along the belt, and along each list."""
    section: int
    task: str = ''
    """A task with a flag; empty: the begin of a cycle, or a point between two steps."""
    follows_move: bool = False
    """It comes after the move that brings its item has begun (semantics 3.3, 3.7)."""
    at_rest: bool = False
    """It also comes after the end of that move."""


class Relation(NamedTuple):
    """One operation must come before another."""

    before: Operation
    after: Operation
    items: int
    """Item offset of the second: 0 is the same item, 1 the next one."""
    tasks: tuple[str, ...] = ()
    """The operations between the two, one after the other; the task of the first is among them."""
    dependency: Dependency | None = None
    """The lateral dependency that requires it; None: a section's list does."""


class _Way(NamedTuple):
    """How far a list, or a track of it, has come."""

    last: Operation
    tasks: list[str]
    """Those that run since then; only the owner of the way appends to it."""


class Operations:
    """The operations of a script for one item, and their order."""

    def __init__(self, script: Script, first_number: int = 0) -> None:
        self.source, self.sink = script.source, script.sink
        self.all: list[Operation] = []
        self.begins: dict[int, Operation] = {}
        """By section: the begin of its cycle."""
        self.turns: dict[int, Operation] = {}
        """By section: the operation that completes its turn (semantics 3.5, 3.8)."""
        self.ends: dict[int, Operation] = {}
        """By section: the end of its cycle."""
        self.of_task: dict[str, Operation] = {}
        self.order: list[Relation] = []
        """The order required by the lists, for one item."""
        self.flags = {dependency.flag: dependency for dependency in script.dependencies}
        self._first_number = first_number
        self._flagged = {*script.upstream_of, *script.downstream_of}
        for section in sorted(script.sections):
            self._add_list(script.sections[section])

    def changed(self, dependency: Dependency) -> Operations:
        """Return a copy with other counts of one flag."""
        operations = copy(self)
        operations.flags = {**self.flags, dependency.flag: dependency}
        return operations

    def _add_list(self, tasks: SectionList) -> None:
        section = tasks.section
        # A source begins ahead of the move, and waits for it where it first needs the belt.
        begin = self._add(section, follows_move=section != self.source)
        self.begins[section] = self.turns[section] = begin
        way, rests = _Way(begin, []), False
        for count, step in enumerate(tasks.steps, 1):
            if step.requires_conveyor and not rests:
                rests = True
                way = self._join(section, [way], at_rest=True)
            way = self._add_step(section, step, way)
            if count == tasks.turn_steps:
                way = self._point(section, way)
                self.turns[section] = way.last
        self.ends[section] = self._point(section, way).last

    def _add_step(self, section: int, step: Step, way: _Way) -> _Way:
        if len(step.tracks) == 1:
            return self._add_track(section, step.tracks[0], way)
        begin = self._point(section, way).last
        ends = [self._add_track(section, track, _Way(begin, [])) for track in step.tracks]
        return self._join(section, ends)

    def _add_track(self, section: int, track: Sequence[Task], way: _Way) -> _Way:
        for task in track:
            if task.id in self._flagged:
                operation = self._add(section, task.id)
                self.of_task[task.id] = operation
                self._lead([way], operation)
                way = _Way(operation, [])
            way.tasks.append(task.id)
        return way

    def _point(self, section: int, way: _Way) -> _Way:
        """Return the way from a moment at which nothing of it runs."""
        return self._join(section, [way]) if way.tasks else way

    def _join(self, section: int, ways: Sequence[_Way], *, at_rest: bool = False) -> _Way:
        """Add the point at which several ways have ended."""
        joined = self._add(section, follows_move=at_rest, at_rest=at_rest)
        self._lead(ways, joined)
        return _Way(joined, [])

    def _lead(self, ways: Sequence[_Way], to: Operation) -> None:
        self.order += [Relation(way.last, to, 0, tuple(way.tasks)) for way in ways]

    def _add(
        self, section: int, task: str = '', *, follows_move: bool = False, at_rest: bool = False
    ) -> Operation:
        number = self._first_number + len(self.all)
        self.all.append(Operation(number, section, task, follows_move, at_rest))
        return self.all[-1]
