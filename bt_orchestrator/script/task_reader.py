"""Reading one task of a script: everything that needs no other task."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from bt_orchestrator.base.errors import UnknownActionType
from bt_orchestrator.model.action_type import ActionType
from bt_orchestrator.model.cell import CONVEYOR, DEFAULT_TIMEOUT_S, Cell, Component, OnFailure
from bt_orchestrator.model.script import INDEX, RunsFor, Task
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.script.capabilities.setups import asked_of
from bt_orchestrator.script.drafts import Position, TaskDraft
from bt_orchestrator.script.fields import Fields
from bt_orchestrator.script.keys import Kind
from bt_orchestrator.script.names import check_id
from bt_orchestrator.script.report import Report, did_you_mean, listing
from bt_orchestrator.script.task_names import read_task_name
from bt_orchestrator.script.yaml_nodes import quoted


class TaskReader:
    """Reads tasks for one cell."""

    def __init__(self, cell: Cell, types: ActionTypes, report: Report) -> None:
        self._cell = cell
        self._types = types
        self._report = report
        self._by_action = {component.action: component for component in cell.components.values()}
        self._known_types: dict[str, ActionType | None] = {}

    def listed(self, fields: Fields, default_id: str, position: Position) -> TaskDraft:
        """Read a task of a section's list."""
        draft = self._draft(fields, default_id, position)
        self._check_section(draft, position.section)
        check_works_on_belt(fields)
        return draft

    def initialization(self, fields: Fields, default_id: str) -> TaskDraft:
        """Read a task of the initialization list (semantics 5.1)."""
        return self._draft(fields, default_id, None)

    def _draft(self, fields: Fields, default_id: str, position: Position | None) -> TaskDraft:
        component = self._component(fields)
        type_ = self._type(component, fields) if component else None
        timeout_s = component.timeout_s if component else DEFAULT_TIMEOUT_S
        task = Task(
            id=read_id(fields) or default_id,
            name=self._name(fields, component, type_),
            action=component.action if component else '',
            component=component.name if component else '',
            **{
                'timeout_s': timeout_s,
                **written_options(fields),
                **asked_of(fields, component),
            },
        )
        return TaskDraft(task, fields, position, component, type_)

    def _component(self, fields: Fields) -> Component | None:
        action = fields.text('action')
        component = self._by_action.get(action) if action is not None else None
        if action is not None and component is None:
            fields.doubt('action')
            hint = did_you_mean(
                action, self._by_action, f'the cell has {listing(self._by_action, longest=8)}'
            )
            what = f'no component of the cell {self._cell.name} has the action {quoted(action)}'
            self._report.add(fields.place('action'), what, hint)
        return component

    def _type(self, component: Component, fields: Fields) -> ActionType | None:
        if component.type not in self._known_types:
            try:
                self._known_types[component.type] = self._types.action(component.type)
            except UnknownActionType as fault:
                self._known_types[component.type] = None
                self._report.add(fields.place('action'), fault.what, fault.hint)
        return self._known_types[component.type]

    def _name(self, fields: Fields, component: Component | None, type_: ActionType | None) -> str:
        if component is None or type_ is None:
            return fields.text('task') or ''
        name = read_task_name(fields, type_, f'a task of `{component.name}` needs the key `task`')
        self._check_index(name, component, type_, fields)
        return name

    def _check_index(
        self, name: str, component: Component, type_: ActionType, fields: Fields
    ) -> None:
        """Refuse the index move as a task: only the belt's own rules may move it (semantics 3.5).

        Every goal of a conveyor type without a task field is an index move.
        """
        if component.name != CONVEYOR:
            return
        if not type_.has_task_field or name == self._cell.conveyor.task:
            place = fields.place('task' if fields.has('task') else 'action')
            what = 'a task cannot move the belt: it indexes by itself when every section is done'
            self._report.add(place, what, 'remove the task')

    def _check_section(self, draft: TaskDraft, section: int) -> None:
        """A component of no section may be used anywhere (formats: cell file)."""
        component = draft.component
        if component is None or not component.sections:
            return
        if section < 1 or section in component.sections:
            return
        here = [c.action for c in self._cell.components.values() if section in c.sections]
        hint = f'section {section} has {listing(here)}' if here else 'move the task'
        numbers = ' and '.join(str(number) for number in component.sections)
        plural = 's' if len(component.sections) > 1 else ''
        what = f'`{component.name}` belongs to section{plural} {numbers}, not to section {section}'
        self._report.add(draft.place('action'), what, hint)


def read_id(fields: Fields) -> str | None:
    """Return the id as written, also a bad one: a reference to it is no second mistake."""
    text = fields.text('id')
    if text is not None:
        check_id(text, 'task id', fields.place('id'), fields.report)
    if text == INDEX:
        what = f'the id `{INDEX}` is reserved for the move of the belt'
        fields.report.add(fields.place('id'), what, 'choose another id')
    return text


def check_works_on_belt(fields: Fields) -> None:
    """Report a task that moves the item while the belt may move (semantics 3.2)."""
    if fields.whole('qty_change') and not fields.switch('requires_conveyor'):
        what = 'a task that changes the quantity works on the belt, so it requires the conveyor'
        fields.report.add(fields.place('requires_conveyor'), what, 'remove this key')


# The keys of a task that say how it is done, wherever they may be written.

_READS: Mapping[Kind, Callable[[Fields, str], Any]] = {
    Kind.SWITCH: Fields.switch,
    Kind.WHOLE: Fields.whole,
    Kind.SECONDS: Fields.seconds,
    Kind.TIMEOUT: lambda fields, key: fields.timeout(key, None),
    Kind.CHOICE: lambda fields, key: RunsFor(fields.choice(key)),
}
"""The reader of each kind of key that sets a field of the task."""


def written_options(fields: Fields) -> dict[str, Any]:
    """Return the fields of Task that a mapping sets; what was not written, or wrongly, is absent.

    Conditions and verdicts need to know the other tasks, and are read later.
    """
    options = {}
    for key in filter(lambda key: key.sets and fields.has(key.name), fields.keys):
        value = _READS[key.kind](fields, key.name)
        if fields.is_sure(key.name):
            options[key.sets] = value
    return options | _on_failure(fields)


def _on_failure(fields: Fields) -> dict[str, OnFailure]:
    given = [key for key in ('on_failure', 'continue_if_fail') if fields.has(key)]
    if not given:
        return {}
    word = fields.choice('on_failure')
    if given == ['continue_if_fail']:
        goes_on = fields.switch('continue_if_fail')
        return {'on_failure': OnFailure.CONTINUE if goes_on else OnFailure.HOLD}
    if len(given) > 1:
        what = '`continue_if_fail` and `on_failure` say the same thing twice'
        fields.report.add(fields.key_place('continue_if_fail'), what, 'keep `on_failure`')
        fields.doubt('on_failure')
    return {'on_failure': OnFailure(word)} if word else {}
