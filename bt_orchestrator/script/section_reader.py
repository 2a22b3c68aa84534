"""Reading the task lists: sections, steps, parallel groups, initialization."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import count

from bt_orchestrator.model.script import Release
from bt_orchestrator.script.drafts import Position, ScriptDraft, SectionDraft, TaskDraft
from bt_orchestrator.script.fields import Fields, fields_of
from bt_orchestrator.script.report import Report, nearest
from bt_orchestrator.script.script_keys import PARALLEL, SECTION
from bt_orchestrator.script.task_keys import INITIALIZATION_TASK, TASK
from bt_orchestrator.script.task_reader import TaskReader
from bt_orchestrator.script.yaml_nodes import Entry, ListNode, MapNode, Node, Scalar, found, quoted

Track = tuple[TaskDraft, ...]

_STEP_HINT = 'write for instance `- {task: TASK_A, action: /my_arm/task}`'


class SectionReader:
    """Reads all task lists of one script into its draft."""

    def __init__(
        self, draft: ScriptDraft, tasks: TaskReader, sections: int, report: Report
    ) -> None:
        self._draft = draft
        self._tasks = tasks
        self._sections = sections
        self._report = report

    def read(self) -> None:
        """Read the initialization list and the sections."""
        self._read_initialization()
        node = self._draft.fields.mapping('sections')
        if node is None or not node.is_complete:
            self._draft.tasks_are_complete = False
        if node is not None and not node.entries and node.is_complete:
            what = 'the script has no sections'
            self._report.add(node.place, what, 'give the task list of at least one section')
        for entry in node.entries if node else ():
            self._read_section(entry)

    def _read_initialization(self) -> None:
        for number, node in enumerate(self._draft.fields.items('initialization'), 1):
            fields = self._task_fields(node, initialization=True)
            if fields is not None:
                task = self._tasks.initialization(fields, f'init.{number}')
                self._draft.initialization.append(task)
                self._note_id(task)
        if not self._draft.fields.is_sure('initialization'):
            self._draft.tasks_are_complete = False

    # --- sections -------------------------------------------------------------------------

    def _read_section(self, entry: Entry) -> None:
        number = self._number(entry)
        if number is None:
            self._draft.tasks_are_complete &= _is_empty(entry.value)
            return
        fields = self._section_fields(entry)
        nodes = self._steps(entry.value, fields, number)
        if nodes is None:
            self._draft.tasks_are_complete = False
            return
        counter = count(1)
        release = Release(
            (fields.choice('release_conveyor') if fields else None) or 'end_of_cycle'
        )
        steps = tuple(
            tuple(self._tracks(node, number, step, counter)) for step, node in enumerate(nodes)
        )
        place = fields.place('release_conveyor') if fields else entry.key.place
        self._draft.sections[number] = SectionDraft(number, entry.key.place, release, place, steps)

    def _number(self, entry: Entry) -> int | None:
        """Return a section's number; its key is the text as written."""
        text = entry.key.text
        if text in {str(number) for number in range(1, self._sections + 1)}:
            return int(text)
        what = f'{quoted(text)} is not a section of the belt'
        self._report.add(entry.key.place, what, f'the sections are 1 to {self._sections}')
        return None

    def _section_fields(self, entry: Entry) -> Fields | None:
        """Return the cursor of a section that is written as a mapping."""
        node = entry.value
        if not isinstance(node, MapNode) or (node.find('action') and not node.find('tasks')):
            return None
        return Fields(node, SECTION, self._report)

    def _steps(self, node: Node, fields: Fields | None, number: int) -> tuple[Node, ...] | None:
        items = node.items if isinstance(node, ListNode) else None
        place = node.place
        if fields is not None:
            items = fields.items('tasks')
            place = fields.place('tasks')
            if not fields.is_sure('tasks'):
                return None
        if _is_empty(node):
            items = ()
        if items is None:
            what = f'a section must be a list of tasks, not {found(node)}'
            self._report.add(place, what, _STEP_HINT)
        elif not items:
            what = f'section {number} has no tasks'
            self._report.add(place, what, 'give it a task, or leave the section out')
        return items

    # --- steps ----------------------------------------------------------------------------

    def _tracks(self, node: Node, section: int, step: int, counter: count[int]) -> Iterator[Track]:
        """Yield the tracks of one step; a task alone is one track."""
        if not _is_group(node):
            yield tuple(self._track((node,), Position(section, step, 0, 0), counter))
            return
        members = fields_of(node, PARALLEL, self._report)
        items = members.items('parallel') if members else ()
        if members and not members.is_sure('parallel'):
            self._draft.tasks_are_complete = False
        elif members and len(items) < 2:
            what = 'a parallel group needs at least two members'
            self._report.add(members.place('parallel'), what, 'add one, or write a plain task')
        for track, member in enumerate(items):
            yield self._member(member, Position(section, step, track, 0), counter)

    def _member(self, node: Node, position: Position, counter: count[int]) -> Track:
        nodes = node.items if isinstance(node, ListNode) else (node,)
        if not nodes:
            what = 'this member of a parallel group has no tasks'
            self._report.add(node.place, what, 'give it a task, or remove it')
        return tuple(self._track(nodes, position, counter))

    def _track(
        self, nodes: tuple[Node, ...], start: Position, counter: count[int]
    ) -> Iterator[TaskDraft]:
        for index, node in enumerate(nodes):
            default_id = f'{start.section}.{next(counter)}'
            fields = self._task_fields(node)
            if fields is not None:
                task = self._tasks.listed(fields, default_id, replace(start, index=index))
                self._note_id(task)
                yield task

    def _task_fields(self, node: Node, initialization: bool = False) -> Fields | None:
        """Return the cursor of a task; None if it is none (reported)."""
        if _is_group(node):
            what = 'a parallel group cannot stand here'
            hint = 'tasks that are not ordered run side by side here anyway'
            nested = 'a member is a task, or a list of tasks run in order'
            self._report.add(node.place, what, hint if initialization else nested)
        elif not isinstance(node, MapNode):
            self._report.add(
                node.place, f'a task must be a mapping, not {found(node)}', _STEP_HINT
            )
        else:
            table = INITIALIZATION_TASK if initialization else TASK
            return Fields(node, table, self._report)
        self._draft.tasks_are_complete = False
        return None

    def _note_id(self, task: TaskDraft) -> None:
        """Report a second task of one id: results, flags and journals go by it."""
        self._draft.ids_are_complete &= task.fields.is_sure('id')
        other = self._draft.by_id.setdefault(task.id, task)
        if other is task:
            return
        first, second = sorted((other, task), key=lambda one: one.fields.node.place)
        if second.fields.has('id'):
            what = f'the id `{task.id}` is given twice'
            hint = f'rename one; the first is in line {first.line}'
        else:
            what = f'this task has no id, and its default `{task.id}` is taken'
            hint = f'give it an id; the other task is in line {first.line}'
        self._report.add(second.place('id'), what, hint)


def _is_empty(node: Node) -> bool:
    is_nothing = isinstance(node, Scalar) and node.value is None
    return is_nothing or (isinstance(node, ListNode) and not node.items)


def _is_group(node: Node) -> bool:
    """Tell whether a step is meant as a parallel group, even if the word is misspelt."""
    if not isinstance(node, MapNode) or node.find('action'):
        return isinstance(node, MapNode) and node.find('parallel') is not None
    words = (entry.key.text for entry in node.entries)
    return any(nearest(word, ('parallel',), likeness=0.75) for word in words)
