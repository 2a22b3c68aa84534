"""The operations of one script; each one represents that operation for every item.

Only what another section can wait for is an operation: tasks with flags, and their relations to
the belt. Everything else in a list takes time, and always ends.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from copy import copy
from itertools import pairwise
from typing import NamedTuple

from bt_orchestrator.model.script import Dependency, Script, SectionList, Step


class Operation(NamedTuple):
    """Something that a section does once for every item."""

    number: int
    """Unique; ascending along the belt, and along each list."""
    section: int
    task: str = ''
    """A task with a flag; empty: the begin of a cycle, or a point between two steps."""
    follows_move: bool = False
    """It comes after the move that brings its item (semantics 3.3, 3.7)."""


class Relation(NamedTuple):
    """One operation must come before another."""

    before: Operation
    after: Operation
    items: int
    """Item offset of the second: 0 is the same item, 1 the next one."""
    dependency: Dependency | None = None
    """The lateral dependency that requires it; None: a section's list does."""


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
        self.flags = {one.flag: one for one in script.dependencies}
        self._first_number = first_number
        self._flagged = {*script.upstream_of, *script.downstream_of}
        for section in sorted(script.sections):
            self._add_list(script.sections[section])

    def changed(self, dependency: Dependency) -> Operations:
        """Return a copy with other counts of one flag."""
        found = copy(self)
        found.flags = {**self.flags, dependency.flag: dependency}
        return found

    def _add_list(self, tasks: SectionList) -> None:
        section = tasks.section
        # A source begins ahead of the move, and waits for it where it first needs the belt.
        rests = section != self.source
        last = self._add(section, follows_move=rests)
        self.begins[section] = self.turns[section] = last
        for count, step in enumerate(tasks.steps, 1):
            if step.requires_conveyor and not rests:
                rests = True
                last = self._join(section, [last], follows_move=True)
            ends = list(self._add_step(section, step, last))
            if len(ends) > 1:
                last = self._join(section, ends)
            elif ends:
                last = ends[0]
            if count == tasks.turn_steps:
                self.turns[section] = last
        self.ends[section] = last

    def _add_step(self, section: int, step: Step, begin: Operation) -> Iterator[Operation]:
        """Add the operations of a step's tracks; yield the last one of each track that has any."""
        for track in step.tracks:
            flagged = [task.id for task in track if task.id in self._flagged]
            if flagged:
                found = {task: self._add(section, task) for task in flagged}
                self.of_task |= found
                self._in_order([begin, *found.values()])
                yield found[flagged[-1]]

    def _join(
        self, section: int, ends: Iterable[Operation], *, follows_move: bool = False
    ) -> Operation:
        """Add the point at which several operations have ended."""
        joined = self._add(section, follows_move=follows_move)
        for end in ends:
            self._in_order([end, joined])
        return joined

    def _in_order(self, operations: list[Operation]) -> None:
        self.order += [Relation(before, after, 0) for before, after in pairwise(operations)]

    def _add(self, section: int, task: str = '', *, follows_move: bool = False) -> Operation:
        number = self._first_number + len(self.all)
        self.all.append(Operation(number, section, task, follows_move))
        return self.all[-1]
