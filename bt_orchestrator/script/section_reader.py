"""Reading the task lists: sections, steps, parallel groups, initialization."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import count

from bt_orchestrator.model.limits import INITIALIZATION
from bt_orchestrator.model.script import Release
from bt_orchestrator.script.drafts import (
    Position,
    RepeatDraft,
    ScriptDraft,
    SectionDraft,
    TaskDraft,
)
from bt_orchestrator.script.fields import Fields, fields_of
from bt_orchestrator.script.report import Report, nearest
from bt_orchestrator.script.script_keys import PARALLEL, REPEAT, SECTION
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
        self._prefix = ''
        """Of the default ids of the list that is read; `_counter` is their end."""
        self._counter = count(1)
        self._is_repeated = False

    def read(self) -> None:
        """Read the initialization list and the sections."""
        self._read_initialization()
        node = self._draft.fields.mapping('sections')
        if node is None:
            self._draft.note_unread(self._draft.fields.node)
            return
        if not node.entries and node.is_complete:
            what = 'the script has no sections'
            self._report.add(node.place, what, 'give the task list of at least one section')
        for entry in node.entries:
            self._read_section(entry)
        for entry in node.repeated:
            self._read_stray(entry, is_repeated=True)
        for lost in node.lost:
            self._draft.note_unread(lost)

    def _read_initialization(self) -> None:
        number = count(1)
        for node in self._draft.fields.items('initialization'):
            for fields in self._task_fields(node, is_initialization=True):
                task = self._tasks.initialization(fields, f'init.{next(number)}')
                self._draft.initialization.append(task)
                self._note_id(task)
                if len(self._draft.initialization) == INITIALIZATION + 1:
                    what = f'initialization has more than {INITIALIZATION} tasks'
                    self._report.add(node.place, what, 'let a section do the others')
        if not self._draft.fields.is_sure('initialization'):
            self._draft.note_unread_words(self._draft.fields.unread_words('initialization'))

    # --- sections -------------------------------------------------------------------------

    def _read_section(self, entry: Entry) -> None:
        number = self._number(entry)
        if number is None:
            self._read_stray(entry)
        else:
            self._draft.sections[number] = self._section(entry, number)

    def _read_stray(self, entry: Entry, is_repeated: bool = False) -> None:
        """Read a list whose section is not known, for the mistakes in it and the ids.

        Where the list is there twice, so are perhaps its ids, which is no further mistake.
        """
        if not _is_empty(entry.value):
            number = -len(self._draft.strays)
            self._draft.strays[number] = self._section(entry, number, is_repeated)

    def _section(self, entry: Entry, number: int, is_repeated: bool = False) -> SectionDraft:
        fields = self._section_fields(entry)
        nodes = self._steps(entry, fields)
        word = fields.choice('release_conveyor') if fields else None
        place = fields.place('release_conveyor') if fields else entry.key.place
        self._is_repeated, self._prefix, self._counter = is_repeated, entry.key.text, count(1)
        steps = tuple(tuple(self._tracks(node, number, step)) for step, node in enumerate(nodes))
        return SectionDraft(
            number,
            entry.key.text,
            entry.key.place,
            Release(word or 'end_of_cycle'),
            place,
            steps,
            is_repeated,
        )

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

    def _steps(self, entry: Entry, fields: Fields | None) -> tuple[Node, ...]:
        node = entry.value
        if fields is not None:
            items = fields.items('tasks')
            if not fields.is_sure('tasks'):
                self._draft.note_unread(node)
                return items
        elif isinstance(node, ListNode) or _is_empty(node):
            items = node.items if isinstance(node, ListNode) else ()
        else:
            what = f'a section must be a list of tasks, not {found(node)}'
            self._report.add(node.place, what, _STEP_HINT)
            if isinstance(node, MapNode):
                return (node,)
            self._draft.note_unread(node)
            return ()
        if not items:
            place = fields.place('tasks') if fields else node.place
            what = f'section {entry.key.text} has no tasks'
            self._report.add(place, what, 'give it a task, or leave the section out')
        return items

    # --- steps ----------------------------------------------------------------------------

    def _tracks(self, node: Node, section: int, step: int) -> Iterator[Track]:
        """Yield the tracks of one step; a task alone is one track."""
        if not _is_group(node):
            alone = Position(section, step, 0, 0)
            yield (
                self._repeat(node, alone)
                if _is_repeat(node)
                else tuple(self._track((node,), alone))
            )
            return
        members = fields_of(node, PARALLEL, self._report)
        items = members.items('parallel') if members else ()
        if members and not members.is_sure('parallel'):
            self._draft.note_unread(node)
        elif members and len(items) < 2:
            what = 'a parallel group needs at least two members'
            self._report.add(members.place('parallel'), what, 'add one, or write a plain task')
        for track, member in enumerate(items):
            yield self._member(member, Position(section, step, track, 0))

    def _member(self, node: Node, position: Position) -> Track:
        if _is_repeat(node):
            return self._repeat(node, position)
        nodes = node.items if isinstance(node, ListNode) else (node,)
        if not nodes:
            what = 'this member of a parallel group has no tasks'
            self._report.add(node.place, what, 'give it a task, or remove it')
        return tuple(self._track(nodes, position))

    def _repeat(self, node: Node, position: Position) -> Track:
        """Read the tasks that are run in order, and perhaps again."""
        fields = fields_of(node, REPEAT, self._report)
        items = fields.items('repeat') if fields else ()
        if fields is None or not fields.is_sure('repeat'):
            self._draft.note_unread(node)
            return ()
        if not items:
            what = 'this repeat has no tasks'
            self._report.add(fields.place('repeat'), what, 'give it a task, or remove it')
        tasks = tuple(self._track(items, position))
        self._draft.repeats.append(RepeatDraft(tasks, fields.whole('times'), fields.node.place))
        return tasks

    def _track(self, nodes: tuple[Node, ...], start: Position) -> Iterator[TaskDraft]:
        each = (fields for node in nodes for fields in self._task_fields(node))
        for index, fields in enumerate(each):
            default_id = f'{self._prefix}.{next(self._counter)}'
            task = self._tasks.listed(fields, default_id, replace(start, index=index))
            self._note_id(task)
            yield task

    def _task_fields(self, node: Node, is_initialization: bool = False) -> Iterator[Fields]:
        """Yield the cursor of a task; of each, where a list or a group stands (reported)."""
        if _is_group(node):
            what = 'a parallel group cannot stand here'
            hint = 'tasks that are not ordered run side by side here anyway'
            nested = 'a member is a task, or a list of tasks run in order'
            self._report.add(node.place, what, hint if is_initialization else nested)
        elif _is_repeat(node):
            what = 'a repeat cannot stand here'
            hint = 'it is a step of a section, or a member of a parallel group'
            self._report.add(node.place, what, hint)
        elif not isinstance(node, MapNode):
            self._report.add(
                node.place, f'a task must be a mapping, not {found(node)}', _STEP_HINT
            )
        table = INITIALIZATION_TASK if is_initialization else TASK
        for task in self._tasks_in(node):
            yield Fields(task, table, self._report)

    def _tasks_in(self, node: Node) -> Iterator[MapNode]:
        """Yield the tasks in a step, whatever their order."""
        if isinstance(node, Scalar):
            if node.value is not None:
                self._draft.note_unread(node)
        elif isinstance(node, ListNode):
            for item in node.items:
                yield from self._tasks_in(item)
        elif _is_group(node):
            for item in Fields(node, PARALLEL, self._report).items('parallel'):
                yield from self._tasks_in(item)
        elif _is_repeat(node):
            for item in Fields(node, REPEAT, self._report).items('repeat'):
                yield from self._tasks_in(item)
        else:
            yield node

    def _note_id(self, task: TaskDraft) -> None:
        """Report a second task of one id: results, flags and journals go by it."""
        if not task.fields.is_sure('id'):
            self._draft.note_unread_id(task.fields.unread_words('id'))
        other = self._draft.by_id.setdefault(task.id, task)
        if other is task or (task.section is not None and self._is_repeated):
            return
        first, second = sorted((other, task), key=lambda draft: draft.fields.node.place)
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
    return _has_word(node, 'parallel')


def _is_repeat(node: Node) -> bool:
    """Tell whether a step is meant as a repeat, even if the word is misspelt."""
    return _has_word(node, 'repeat')


def _has_word(node: Node, word: str) -> bool:
    if not isinstance(node, MapNode) or node.find('action'):
        return isinstance(node, MapNode) and node.find(word) is not None
    words = (entry.key.text for entry in node.entries)
    return any(nearest(key, (word,), likeness=0.75) for key in words)
