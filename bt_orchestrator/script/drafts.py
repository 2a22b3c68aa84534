"""A script while it is being checked: tasks with the places of their keys."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

from bt_orchestrator.model.action_type import TASK_RESULT, ActionType, FieldType
from bt_orchestrator.model.cell import Component, OnFailure
from bt_orchestrator.model.script import Parameter, Release, Task
from bt_orchestrator.script.fields import Fields
from bt_orchestrator.script.report import Place
from bt_orchestrator.script.yaml_nodes import Node, words

_DEFAULT_ID = re.compile(r'(init|[0-9]+)\.[0-9]+')


@dataclass(frozen=True)
class Position:
    """Where a task stands in the sections' lists; all but the section count from 0."""

    section: int
    """Below 1: of a list whose section is not known (`ScriptDraft.strays`)."""
    step: int
    track: int
    index: int

    def is_comparable(self, other: Position) -> bool:
        """Tell whether it is known which of two tasks here and there is first."""
        return self.section == other.section or min(self.section, other.section) > 0

    def precedes(self, other: Position) -> bool:
        """Tell whether a task here has surely ended before one there starts, for one item."""
        if self.section != other.section:
            return self.is_comparable(other) and self.section < other.section
        if self.step != other.step:
            return self.step < other.step
        return self.track == other.track and self.index < other.index

    def is_beside(self, other: Position) -> bool:
        """Tell whether tasks here and there are in different tracks of one parallel group."""
        is_same_step = (self.section, self.step) == (other.section, other.step)
        return is_same_step and self.track != other.track


@dataclass(frozen=True)
class TaskDraft:
    """One task as far as it could be read."""

    task: Task
    """Without args and condition; defaults stand for what could not be read (`fields.is_sure`)."""
    fields: Fields
    position: Position | None
    """None: an initialization task."""
    component: Component | None
    """None: the action is unknown."""
    type: ActionType | None

    @property
    def id(self) -> str:
        """Id of the task."""
        return self.task.id

    @property
    def section(self) -> int | None:
        """Number of its section; None: initialization."""
        return self.position.section if self.position else None

    @property
    def line(self) -> int:
        """Line where it begins."""
        return self.fields.node.place.line

    def place(self, key: str) -> Place:
        """Return the place of a key's value, or of the task."""
        return self.fields.place(key)

    def precedes(self, other: TaskDraft) -> bool:
        """Tell whether it has ended before the other one starts, for one item."""
        if self.position is None or other.position is None:
            return False
        return self.position.precedes(other.position)

    def may_precede(self, other: TaskDraft) -> bool:
        """Tell whether that cannot be ruled out: it is so, or a section is not known."""
        if self.position is None or other.position is None:
            return False
        return self.precedes(other) or not self.position.is_comparable(other.position)

    def hint_to_precede(self, other: TaskDraft) -> str:  # noqa: ARG002 - for recipes
        """Say what to write to bring it before another one; empty: no key does that."""
        return ''

    def is_beside(self, other: TaskDraft) -> bool:
        """Tell whether both are in different tracks of one parallel group."""
        if self.position is None or other.position is None:
            return False
        return self.position.is_beside(other.position)

    @property
    def identifies(self) -> bool:
        """Tell whether its result has the serial of the item."""
        return self.fields.has('identifies')

    @property
    def may_reject(self) -> bool:
        """Tell whether a failure rejects the item."""
        return self.task.on_failure is OnFailure.REJECT

    @property
    def results(self) -> Mapping[str, FieldType]:
        """Result fields that are kept on the item (semantics 2.2)."""
        fields = self.type.result.fields if self.type else {}
        return {name: kind for name, kind in fields.items() if not _is_verdict(name, kind)}


@dataclass(frozen=True)
class SectionDraft:
    """One section's list as far as it could be read."""

    section: int
    name: str
    """Its number as written."""
    place: Place
    """Of the section's key."""
    release: Release
    release_place: Place
    steps: tuple[tuple[tuple[TaskDraft, ...], ...], ...]
    """Steps of tracks of tasks."""
    is_repeated: bool = False
    """Whether its section was given before; `number` is then below 1."""

    @property
    def tasks(self) -> Iterator[TaskDraft]:
        """All tasks, in the order written."""
        return (task for step in self.steps for track in step for task in track)

    @property
    def trailing(self) -> tuple[TaskDraft, ...]:
        """Tasks that run after the turn is complete (semantics 3.8)."""
        if self.release is Release.END_OF_CYCLE:
            return ()
        needing = [n for n, step in enumerate(self.steps) if _requires_conveyor(step)]
        behind = self.steps[needing[-1] + 1 :] if needing else ()
        return tuple(task for step in behind for track in step for task in track)


@dataclass(frozen=True)
class RepeatDraft:
    """A repeat as far as it could be read."""

    tasks: tuple[TaskDraft, ...]
    times: int
    place: Place


@dataclass
class ScriptDraft:
    """A script as far as it could be read."""

    fields: Fields
    kind: str = 'script'
    a_step: str = 'a task'
    """The name of one of its tasks in messages."""
    params: dict[str, Parameter] = field(default_factory=dict)
    unread_params: set[str] = field(default_factory=set)
    """Words in what might be parameters and could not be read."""
    initialization: list[TaskDraft] = field(default_factory=list)
    sections: dict[int, SectionDraft] = field(default_factory=dict)
    strays: dict[int, SectionDraft] = field(default_factory=dict)
    """Lists whose section is not on the belt, or was given before; by numbers below 1."""
    repeats: list[RepeatDraft] = field(default_factory=list)
    tasks_are_complete: bool = True
    """False if something that might be a task could not be read."""
    has_lost_id: bool = False
    """Whether the id of some task could not be read."""
    by_id: dict[str, TaskDraft] = field(default_factory=dict)
    """The first task of every id."""
    _unread: set[str] = field(default_factory=set)

    @property
    def step(self) -> str:
        """The name of its tasks in messages, without the article."""
        return self.a_step.partition(' ')[2]

    def note_unread(self, node: Node) -> None:
        """Note that there may be tasks in something that could not be read."""
        self.note_unread_words(words(node))

    def note_unread_words(self, texts: Iterable[str]) -> None:
        """Note that there may be tasks, with these words in them, that could not be read."""
        self.tasks_are_complete = False
        self._unread.update(texts)

    def note_unread_id(self, texts: Iterable[str]) -> None:
        """Note that the id of a task could not be read."""
        ids = [word for word in texts if word]
        self._unread.update(ids)
        self.has_lost_id |= not ids

    def may_have(self, task: str) -> bool:
        """Tell whether there may be a task of that id in what could not be read.

        Only then an id that is not known is no mistake. A default id counts the tasks of a list,
        so none is sure while any list is not.
        """
        if self.has_lost_id or task in self._unread:
            return True
        is_whole = self.tasks_are_complete and not self.strays
        return not is_whole and bool(_DEFAULT_ID.fullmatch(task))

    @property
    def listed(self) -> Iterator[TaskDraft]:
        """All tasks of section lists, along the belt."""
        for number in sorted(self.sections):
            yield from self.sections[number].tasks

    def is_repeated(self, task: TaskDraft) -> bool:
        """Tell whether a task is in a repeat (semantics 3.9)."""
        return any(task is other for repeat in self.repeats for other in repeat.tasks)

    @property
    def lists(self) -> Iterator[SectionDraft]:
        """All lists of tasks; those with an unknown section come last."""
        yield from self.sections.values()
        yield from self.strays.values()

    def trailing(self, task: TaskDraft) -> bool:
        """Tell whether a task runs after its section's turn is complete (semantics 3.8)."""
        number = 1 if task.section is None else task.section
        section = self.sections.get(number) or self.strays.get(number)
        return section is not None and any(task is other for other in section.trailing)


def _is_verdict(name: str, kind: FieldType) -> bool:
    return name == TASK_RESULT and kind.kind == 'bool' and not kind.is_array


def _requires_conveyor(step: tuple[tuple[TaskDraft, ...], ...]) -> bool:
    return any(draft.task.requires_conveyor for track in step for draft in track)
