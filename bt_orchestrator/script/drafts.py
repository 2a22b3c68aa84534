"""A script while it is being checked: tasks with the places of their keys."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from bt_orchestrator.model.action_type import TASK_RESULT, ActionType, FieldType
from bt_orchestrator.model.cell import Component, OnFailure
from bt_orchestrator.model.script import Parameter, Release, Task
from bt_orchestrator.script.fields import Fields
from bt_orchestrator.script.report import Place


@dataclass(frozen=True)
class Position:
    """Where a task stands in the sections' lists; all but the section count from 0."""

    section: int
    step: int
    track: int
    index: int

    def precedes(self, other: Position) -> bool:
        """Tell whether a task here has ended before a task there starts, for one item."""
        if self.section != other.section:
            return self.section < other.section
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

    def is_beside(self, other: TaskDraft) -> bool:
        """Tell whether both are in different tracks of one parallel group."""
        if self.position is None or other.position is None:
            return False
        return self.position.is_beside(other.position)

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
    place: Place
    """Of the section's key."""
    release: Release
    release_place: Place
    steps: tuple[tuple[tuple[TaskDraft, ...], ...], ...]
    """Steps of tracks of tasks."""

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


@dataclass
class ScriptDraft:
    """A script as far as it could be read."""

    fields: Fields
    params: dict[str, Parameter] = field(default_factory=dict)
    params_are_complete: bool = True
    initialization: list[TaskDraft] = field(default_factory=list)
    sections: dict[int, SectionDraft] = field(default_factory=dict)
    tasks_are_complete: bool = True
    """False if something that might be a task could not be read."""
    ids_are_complete: bool = True
    """False if, beyond that, an id could not be read."""
    by_id: dict[str, TaskDraft] = field(default_factory=dict)
    """The first task of every id."""

    @property
    def knows_all_ids(self) -> bool:
        """Tell whether an id that is not here is a mistake."""
        return self.tasks_are_complete and self.ids_are_complete

    @property
    def listed(self) -> Iterator[TaskDraft]:
        """All tasks of section lists, along the belt."""
        for number in sorted(self.sections):
            yield from self.sections[number].tasks

    def trailing(self, task: TaskDraft) -> bool:
        """Tell whether a task runs after its section's turn is complete (semantics 3.8)."""
        section = self.sections.get(task.section or 0)
        return section is not None and any(task is one for one in section.trailing)


def _is_verdict(name: str, kind: FieldType) -> bool:
    return name == TASK_RESULT and kind.kind == 'bool' and not kind.is_array


def _requires_conveyor(step: tuple[tuple[TaskDraft, ...], ...]) -> bool:
    return any(draft.task.requires_conveyor for track in step for draft in track)
