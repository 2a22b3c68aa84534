"""Second pass over a task: arguments, condition, verdict, identity; they may refer to others."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any

from bt_orchestrator.model.action_type import TASK, ActionType, MessageType
from bt_orchestrator.model.reference import Template
from bt_orchestrator.model.script import Task
from bt_orchestrator.script.capabilities.setups import read_change
from bt_orchestrator.script.checks.arguments import MessageReader
from bt_orchestrator.script.checks.references import ReferenceReader
from bt_orchestrator.script.conditions.reader import ConditionReader
from bt_orchestrator.script.drafts import ScriptDraft, TaskDraft
from bt_orchestrator.script.field_types import in_words
from bt_orchestrator.script.fields import Fields
from bt_orchestrator.script.names import check_name
from bt_orchestrator.script.references import has_reference, is_single
from bt_orchestrator.script.report import Report
from bt_orchestrator.script.yaml_nodes import Entry, ListNode, MapNode, Node, Scalar, found, quoted


def complete_task(script: ScriptDraft, draft: TaskDraft, report: Report) -> Task:
    """Return a task with arguments and condition, checked against everything else."""
    references = ReferenceReader(script, draft, report)
    args = goal_arguments(draft.fields, draft.type, references, report)
    change = read_change(draft, args, report)
    if draft.position is None:
        return replace(draft.task, args=args, change=change)
    condition = ConditionReader(draft, references, report).read()
    afterwards = ReferenceReader(script, draft, report, of_verdict=True)
    verdict = ConditionReader(draft, afterwards, report).verdict()
    serial = read_serial(draft, afterwards, report)
    return replace(
        draft.task,
        args=args,
        change=change,
        condition=condition,
        fails_unless=verdict,
        identifies=serial,
    )


def goal_arguments(
    fields: Fields, type_: ActionType | None, references: ReferenceReader, report: Report
) -> dict[str, Any]:
    """Return the goal fields that `args` sets; None for the type: it is not known."""
    node = fields.mapping('args')
    if node is None:
        return {}
    if type_ is None:
        check_references(node, references)
        return {}
    if type_.has_task_field:
        node = _without_task_field(node, report)
    return MessageReader(report, references).read(node, settable(type_))


def check_references(node: Node, references: ReferenceReader) -> None:
    """Report what is wrong in the references in arguments whose types are not known."""
    if isinstance(node, Scalar):
        if has_reference(node):
            references.template(node)
    elif isinstance(node, ListNode):
        for item in node.items:
            check_references(item, references)
    else:
        for entry in node.entries:
            check_references(entry.value, references)


def _without_task_field(node: MapNode, report: Report) -> MapNode:
    """Report an argument that would select another task (semantics 2.1)."""
    entry = node.find(TASK)
    if entry is None:
        return node
    what = f'the field `{TASK}` cannot be an argument: it is set from the name of the task'
    report.add(entry.key.place, what, 'remove it')
    return MapNode(node.place, tuple(other for other in node.entries if other is not entry))


def settable(type_: ActionType) -> MessageType:
    """Return the goal fields that arguments may set."""
    fields = {name: kind for name, kind in type_.goal.fields.items() if name != TASK}
    return MessageType(f'the goal of {type_.name}', fields)


# The identity and the contents of an item: `identifies` and `lots` (semantics 6.8, 6.9).

_NAMED = ('str', 'int')
"""Types of values that may name something."""


def read_serial(task: TaskDraft, references: ReferenceReader, report: Report) -> tuple[str, ...]:
    """Return the path of the result field that is the item's serial; empty: none, or wrong."""
    field = task.fields.text('identifies')
    if field is None:
        return ()
    place = task.place('identifies')
    if '${' in field:
        what = f'`identifies` is the name of a result field of `{task.id}`, not {quoted(field)}'
        report.add(place, what, 'write for instance `identifies: serial`')
        return ()
    read = references.own_field(place, field)
    if read is None:
        return ()
    reference, type_ = read
    if type_ is not None and (type_.kind not in _NAMED or type_.is_array):
        what = f'`identifies` must name text or a whole number, but `{field}` is {in_words(type_)}'
        report.add(place, what, 'name the field that has the serial')
    return reference.fields


def check_serials(tasks: Iterable[TaskDraft], report: Report) -> None:
    """Report a second task that identifies the item (semantics 6.8)."""
    reading = [task for task in tasks if task.identifies and not task.task.qty_change]
    for task in reading[1:]:
        first = reading[0]
        what = f'`{first.id}` (line {first.line}) identifies the item already'
        if task.fields.has('identifies'):
            report.add(task.fields.key_place('identifies'), what, 'keep one of them')
        else:
            hint = 'let `do` name a capability without `identifies`'
            report.add(task.place('do'), what, hint)


def read_lots(script: ScriptDraft, report: Report) -> dict[str, Template]:
    """Return what goes into each item, by name."""
    node = script.fields.mapping('lots')
    return dict(_lots(node.entries if node else (), ReferenceReader(script, None, report), report))


def _lots(
    entries: tuple[Entry, ...], references: ReferenceReader, report: Report
) -> Iterator[tuple[str, Template]]:
    for entry in entries:
        name, value = entry.key.text, entry.value
        check_name(name, 'lot name', entry.key.place, report)
        if not isinstance(value, Scalar) or not has_reference(value):
            what = f'{quoted(name)} must refer to the order, but it is {found(value)}'
            hint = 'write for instance `glue: "${params.glue_lot}"`'
            report.add(value.place, what, hint)
            continue
        read = references.template(value)
        if read is None:
            continue
        template, type_ = read
        if is_single(template) and type_ is not None and type_.kind not in _NAMED:
            lot, given = quoted(name), quoted(str(template))
            what = f'{lot} must be text or a whole number, but {given} is'
            report.add(value.place, f'{what} {in_words(type_)}', 'refer to a value of that type')
        yield name, template
