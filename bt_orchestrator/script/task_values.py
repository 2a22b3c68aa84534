"""Second pass over a task: arguments, condition and verdict, which may refer to other tasks."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from bt_orchestrator.model.action_type import TASK, ActionType, MessageType
from bt_orchestrator.model.script import Task
from bt_orchestrator.script.capabilities.setups import read_change
from bt_orchestrator.script.checks.arguments import MessageReader
from bt_orchestrator.script.checks.references import ReferenceReader
from bt_orchestrator.script.conditions.reader import ConditionReader
from bt_orchestrator.script.drafts import ScriptDraft, TaskDraft
from bt_orchestrator.script.fields import Fields
from bt_orchestrator.script.identity_reader import read_serial
from bt_orchestrator.script.references import has_reference
from bt_orchestrator.script.report import Report
from bt_orchestrator.script.yaml_nodes import ListNode, MapNode, Node, Scalar


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
    return MessageReader(report, references).read(node, _settable(type_))


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
    return MapNode(node.place, tuple(one for one in node.entries if one is not entry))


def _settable(type_: ActionType) -> MessageType:
    """Return the goal fields that arguments may set."""
    fields = {name: kind for name, kind in type_.goal.fields.items() if name != TASK}
    return MessageType(f'the goal of {type_.name}', fields)
