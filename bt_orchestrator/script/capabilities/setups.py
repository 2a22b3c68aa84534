"""Setups: what a component can be set up for, what tasks ask for, and whether both fit (5.3)."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

from bt_orchestrator.base.errors import UnknownActionType
from bt_orchestrator.model.action_type import TASK, ActionType, FieldType
from bt_orchestrator.model.cell import Component, Setup, StateTopic
from bt_orchestrator.model.jobs.setups import change_by, change_id
from bt_orchestrator.model.script import RunsFor, Script, SetupChange, Task
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.script.capabilities.capability_keys import CHANGE, CHANGES, SETUPS
from bt_orchestrator.script.checks.arguments import MessageReader
from bt_orchestrator.script.drafts import ScriptDraft, TaskDraft
from bt_orchestrator.script.field_types import simple_type
from bt_orchestrator.script.fields import Fields
from bt_orchestrator.script.names import check_name
from bt_orchestrator.script.report import Report, did_you_mean, listing
from bt_orchestrator.script.task_names import check_task_name
from bt_orchestrator.script.yaml_nodes import Entry, ListNode, MapNode, Node, Scalar, found, quoted

# --- the cell file ------------------------------------------------------------------------------


class SetupReader:
    """Reads the setups of one component, and what changes them."""

    def __init__(
        self,
        fields: Fields,
        name: str,
        type_: ActionType | None,
        state: StateTopic | None,
        types: ActionTypes,
    ) -> None:
        self._fields, self._name, self._type = fields, name, type_
        self._state, self._types = state, types
        self._report = fields.report

    @property
    def offered(self) -> Mapping[str, Collection[str]]:
        """Every setup with its values, as far as they are written."""
        return {
            entry.key.text: [item.text for item in entry.value.items if isinstance(item, Scalar)]
            for entry in _entries(self._fields, 'setups')
            if isinstance(entry.value, ListNode)
        }

    def setups(self) -> Mapping[str, Setup]:
        """Return the setups that have a change; what is wrong is reported."""
        values = {entry.key.text: entry for entry in _entries(self._fields, 'setups')}
        changes = {entry.key.text: entry for entry in _entries(self._fields, 'changes')}
        for setup in filter(lambda name: name not in values, changes):
            hint = did_you_mean(setup, values, f'list its values in `{SETUPS.name}`')
            what = f'`{self._name}` has no setup {quoted(setup)}'
            self._report.add(changes[setup].key.place, what, hint)
        if not self._fields.is_sure('setups', 'changes'):
            return {}
        made = {name: self._setup(entry, changes.get(name)) for name, entry in values.items()}
        self._check_once(changes)
        return {name: setup for name, setup in made.items() if setup is not None}

    def _setup(self, entry: Entry, change: Entry | None) -> Setup | None:
        name = entry.key.text
        check_name(name, 'setup', entry.key.place, self._report)
        nodes = dict(self._values(entry))
        if change is None:
            what = f'nothing says how the setup `{name}` is changed'
            self._report.add(entry.key.place, what, CHANGES.hint)
            return None
        task, argument, reads = self._change(name, change)
        values = {value: self._argument(node, argument) for value, node in nodes.items()}
        kind = self._reading(change, reads)
        if kind is None:
            return Setup(values, task, argument)
        readings = {value: self._told(node, reads, kind) for value, node in nodes.items()}
        return Setup(values, task, argument, reads, readings)

    def _values(self, entry: Entry) -> Iterator[tuple[str, Scalar]]:
        items = entry.value.items if isinstance(entry.value, ListNode) else ()
        if len(items) < 2:
            what = f'the setup `{entry.key.text}` needs a list of at least two values'
            self._report.add(entry.value.place, what, SETUPS.hint)
        seen: set[str] = set()
        for item in items:
            if not isinstance(item, Scalar) or not item.text:
                what = f'a value of a setup must be a name, not {found(item)}'
                self._report.add(item.place, what, SETUPS.hint)
            elif item.text in seen:
                what = f'the value {quoted(item.text)} is given twice'
                self._report.add(item.place, what, 'remove one')
            elif check_name(item.text, 'value of a setup', item.place, self._report):
                seen.add(item.text)
                yield item.text, item

    def _change(self, setup: str, entry: Entry) -> tuple[str, str, str]:
        """Return the task and the goal field of a change, and what tells its value.

        The goal field is empty if it is wrong.
        """
        node, place, reads = entry.value, entry.value.place, ''
        if isinstance(node, Scalar) and node.text:
            task, argument = node.text, setup
        elif isinstance(node, MapNode):
            fields = Fields(node, CHANGE, self._report)
            task, argument = fields.text('task') or '', fields.text('argument') or setup
            place, reads = fields.place('argument'), fields.text('reads') or ''
        else:
            what = f'a change must name its task, not {found(node)}'
            self._report.add(place, what, CHANGES.hint)
            return '', '', ''
        if self._type is None:
            return task, '', reads
        if task:
            check_task_name(task, self._type, entry.value.place, self._report)
        goal = {name: field for name, field in self._type.goal.fields.items() if name != TASK}
        if argument in goal:
            return task, argument, reads
        what = f'{self._type.goal.name} has no field {quoted(argument)} for the value'
        hint = f'name one with `argument`: {listing(goal)}'
        if argument != setup:
            hint = did_you_mean(argument, goal, hint)
        self._report.add(place, what, hint)
        return task, '', reads

    def _reading(self, entry: Entry, field: str) -> FieldType | None:
        """Return the type of the field that tells a setup; None: there is none, or it is wrong."""
        node = entry.value
        reads = node.find('reads') if isinstance(node, MapNode) else None
        if reads is None or not field:
            return None
        place = reads.value.place
        if self._state is None:
            if not self._fields.has('state'):
                what = f'`{self._name}` has no state topic that tells a setup'
                self._report.add(place, what, 'give it `state`, or remove `reads`')
            return None
        try:
            ros_name = self._types.message_field(self._state.type, field)
        except UnknownActionType as fault:
            if ' field ' in fault.what:  # else the type was reported before
                self._report.add(place, fault.what, fault.hint)
            return None
        known = simple_type(ros_name)
        if known is None or known.kind in ('float', 'bytes'):
            what = f'the field `{field}` of {self._state.type} is {ros_name}'
            hint = 'name one that is a text, a whole number or a boolean'
            self._report.add(place, f'{what}, which tells no setup', hint)
            return None
        return known

    def _told(self, node: Scalar, field: str, kind: FieldType) -> Any:
        if kind.kind == 'str':
            return node.text
        return MessageReader(self._report).value(node, kind, field)

    def _argument(self, node: Scalar, field: str) -> Any:
        if self._type is None or not field:
            return node.text
        return MessageReader(self._report).value(node, self._type.goal.fields[field], field)

    def _check_once(self, changes: Mapping[str, Entry]) -> None:
        """Report a task that changes two setups: what it was would depend on its arguments."""
        owners: dict[str, str] = {}
        for setup, entry in changes.items():
            named = entry.value.find('task') if isinstance(entry.value, MapNode) else None
            node = named.value if named is not None else entry.value
            task = node.text if isinstance(node, Scalar) else ''
            if task and owners.setdefault(task, setup) != setup:
                what = f'the task `{task}` changes the setup `{owners[task]}` already'
                self._report.add(node.place, what, 'give each setup a task of its own')


# --- tasks --------------------------------------------------------------------------------------


def read_setup(
    fields: Fields, name: str, offered: Mapping[str, Collection[str]]
) -> dict[str, str]:
    """Return what a task, or a capability, asks of its component.

    :param name: of the component
    :param offered: its setups with their values
    """
    asked = {}
    for entry in _entries(fields, 'setup'):
        setup, node = entry.key.text, entry.value
        text = node.text if isinstance(node, Scalar) else ''
        if setup not in offered:
            known = f'its setups are {listing(offered)}' if offered else 'give it `setups`'
            what = f'`{name}` has no setup {quoted(setup)}'
            fields.report.add(entry.key.place, what, did_you_mean(setup, offered, known))
        elif text not in offered[setup]:
            what = f'the setup `{setup}` of `{name}` cannot be {_shown(node)}'
            known = f'its values are {listing(offered[setup])}'
            fields.report.add(node.place, what, did_you_mean(text, offered[setup], known))
        else:
            asked[setup] = text
    return asked


def asked_of(fields: Fields, component: Component | None) -> dict[str, Any]:
    """Return what a task of a script asks of its component, as a field of the task; or nothing."""
    if component is None or not fields.has('setup'):
        return {}
    offered = {name: setup.values for name, setup in component.setups.items()}
    return {'setup': read_setup(fields, component.name, offered)}


def check_setups(script: Script, draft: ScriptDraft, report: Report) -> None:
    """Report tasks that would find another setup than they ask for, and changes that may not come.

    Semantics 5.3.
    """
    listed = [
        (number, task) for number, section in script.sections.items() for task in section.tasks
    ]
    used: dict[tuple[str, str], list[tuple[int, Task]]] = {}
    for number, task in listed:
        setups = dict.fromkeys([*task.setup, *([task.change.setup] if task.change else [])])
        for setup in setups:
            used.setdefault((task.component, setup), []).append((number, task))
        if task.change is not None:
            _check_change(script, draft.by_id[task.id], report)
    for (component, setup), tasks in used.items():
        _check_together(setup, tasks, draft, report)
        for number in sorted({number for number, _ in tasks}):
            _check_order(setup, [task for n, task in tasks if n == number], draft, report)
        for value in dict.fromkeys(task.setup[setup] for _, task in tasks if setup in task.setup):
            taken = draft.by_id.get(change_id(component, setup, value))
            if taken is not None:
                what = f'`{taken.id}` is the id of a change that this script implies'
                report.add(taken.place('id'), what, 'choose another id')


def _check_change(script: Script, task: TaskDraft, report: Report) -> None:
    """Report a change that does not come for every item, once."""
    if task.id in script.repeat_of:
        what = f'`{task.id}` changes a setup, and cannot be repeated'
        report.add(task.fields.node.place, what, 'put it before or behind the repeat')
    skips = [key for key in ('when', 'unless') if task.fields.has(key)]
    if skips or task.task.runs_for is not RunsFor.ALL:
        what = f'`{task.id}` changes a setup, so it must run for every item'
        hint = f'remove `{skips[0]}`' if skips else 'write `runs_for: all`'
        report.add(task.place(skips[0] if skips else 'runs_for'), what, hint)


def _check_together(
    setup: str, tasks: Sequence[tuple[int, Task]], draft: ScriptDraft, report: Report
) -> None:
    """Report different values in sections, which work side by side."""
    (first_section, first), *others = tasks
    for number, task in others:
        if number != first_section and _values(task, setup) != _values(first, setup):
            there = f'`{first.id}` in section {first_section} with {_shown_values(first, setup)}'
            what = f'`{task.id}` works with {setup} {_shown_values(task, setup)}, and {there}'
            hint = 'sections work side by side: use one value, or a component for each'
            _add(report, draft.by_id[task.id], what, hint)
            return


def _check_order(setup: str, tasks: Sequence[Task], draft: ScriptDraft, report: Report) -> None:
    """Report a task that comes where the setup has another value, for this item or the next."""
    value, by, first = '', '', None
    for task in tasks:
        wanted = task.setup.get(setup)
        if wanted is not None and value and value != wanted:
            what = f'`{task.id}` asks for {setup} {wanted}, but it is {value} there (`{by}`)'
            _add(report, draft.by_id[task.id], what, 'put a task between them that changes it')
            return
        if wanted is not None:
            first = first or (None if value else task)
            value, by = wanted, task.id
        if task.change is not None and task.change.setup == setup:
            value, by = task.change.value, task.id
    if first is not None and first.setup[setup] != value:
        what = f'`{by}` leaves {setup} {value}, but `{first.id}` asks for {first.setup[setup]}'
        hint = 'change it back for the next item, behind the last task that needs it'
        report.add(draft.by_id[by].fields.node.place, what, hint)


def _values(task: Task, setup: str) -> set[str]:
    asked = {task.setup[setup]} if setup in task.setup else set()
    changes = task.change is not None and task.change.setup == setup
    return asked | ({task.change.value} if task.change is not None and changes else set())


def _shown_values(task: Task, setup: str) -> str:
    return ' and '.join(sorted(_values(task, setup)))


def _add(report: Report, task: TaskDraft, what: str, hint: str) -> None:
    report.add(task.place('setup'), what, hint)


def read_change(draft: TaskDraft, args: Mapping[str, Any], report: Report) -> SetupChange | None:
    """Return the setup that a task changes; a value that is not known before is reported."""
    component = draft.component
    if component is None or not component.setups:
        return None
    task = draft.task
    change = change_by(component, task.name, args)
    for name, setup in component.setups.items():
        if change is None and setup.task == task.name and draft.fields.is_sure('args', 'task'):
            what = f'`{task.id}` changes the setup `{name}`, so its new value must be known'
            hint = f'write `args: {{{setup.argument}: ...}}` with one of {listing(setup.values)}'
            report.add(draft.place('args'), what, hint)
    return change


def _shown(node: Node) -> str:
    return quoted(node.text) if isinstance(node, Scalar) and node.text else found(node)


def _entries(fields: Fields, key: str) -> tuple[Entry, ...]:
    node = fields.mapping(key)
    return (*node.entries, *node.repeated) if node is not None else ()
