"""Reading one component of a cell file, or the conveyor's controller, against its action type."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from bt_orchestrator.base.errors import UnknownActionType
from bt_orchestrator.model.action_type import ActionType, FieldType, MessageType
from bt_orchestrator.model.cell import DEFAULT_TIMEOUT_S, Component, StateTopic
from bt_orchestrator.model.fault import Fault, parse_fault
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.script.capabilities.capability_reader import CapabilityReader
from bt_orchestrator.script.capabilities.setups import SetupReader
from bt_orchestrator.script.checks.arguments import MessageReader
from bt_orchestrator.script.checks.faults import unseen
from bt_orchestrator.script.field_types import misfit, simple_type
from bt_orchestrator.script.fields import Fields
from bt_orchestrator.script.keys import LONGEST_SECONDS
from bt_orchestrator.script.report import Report
from bt_orchestrator.script.ros_names import (
    check_action_name,
    check_topic_name,
    check_type_name,
)
from bt_orchestrator.script.task_names import check_task_name, read_task_name
from bt_orchestrator.script.yaml_nodes import ListNode, MapNode, Node, Scalar, found


class ComponentReader:
    """Reads the keys that a component and the conveyor share, and those of each."""

    def __init__(self, fields: Fields, name: str, report: Report, types: ActionTypes) -> None:
        self._fields = fields
        self._name = name
        self._report = report
        self._types = types
        self._type = self._action_type()

    def component(self, sections: int | None) -> Component:
        """Return a component; `sections` is the length of the belt, if known."""
        own, shared = self._sections(sections), self._shared()
        setups = SetupReader(self._fields, self._name, self._type, shared.state, self._types)
        reader = CapabilityReader(self._fields, self._name, self._type, setups.offered)
        return replace(
            shared,
            sections=own,
            durations_s=self._durations(),
            capabilities={capability.name: capability for capability in reader.capabilities()},
            workspaces=reader.workspaces(own),
            setups=setups.setups(),
        )

    def conveyor(self) -> Component:
        """Return the conveyor's controller, a component of no section."""
        return replace(self._shared(), default_duration_s=self._fields.seconds('duration'))

    def index_task(self) -> str:
        """Return the task of one index move."""
        if self._type is None:
            return self._fields.text('task') or ''
        missing = f'the conveyor needs the key `task`: {self._type.name} has several tasks'
        hint = 'name the constant of one index move'
        return read_task_name(self._fields, self._type, missing, hint)

    def _shared(self) -> Component:
        action = self._fields.text('action')
        if action is not None:
            place = self._fields.place('action')
            action = action if check_action_name(action, place, self._report) else None
        return Component(
            name=self._name,
            sections=(),
            action=action or '',
            type=self._type.name if self._type else '',
            state=self._state(),
            timeout_s=self._fields.timeout('timeout', DEFAULT_TIMEOUT_S),
            result_timeout_s=self._fields.seconds('result_timeout'),
            results=self._results(),
            faults=tuple(self._faults()),
            prepare=CapabilityReader(self._fields, self._name, self._type).preparation(),
        )

    def _action_type(self) -> ActionType | None:
        name = self._fields.text('type')
        place = self._fields.place('type')
        if name is None or not check_type_name(name, 'action', place, self._report):
            return None
        try:
            return self._types.action(name)
        except UnknownActionType as fault:
            self._report.add(place, fault.what, fault.hint)
            return None

    # --- sections -------------------------------------------------------------------------

    def _sections(self, last: int | None) -> tuple[int, ...]:
        node = self._fields.value('section')
        if node is None:
            return ()
        items = node.items if isinstance(node, ListNode) else (node,)
        if not items:
            what = 'the list of sections is empty'
            self._report.add(node.place, what, 'leave `section` out for a component of no section')
        numbers: list[int] = []
        for item in items:
            number = self._section(item, last)
            if number in numbers:
                self._report.add(item.place, f'section {number} is given twice', 'remove one')
            elif number is not None:
                numbers.append(number)
        return tuple(sorted(numbers))

    def _section(self, node: Node, last: int | None) -> int | None:
        value = node.value if isinstance(node, Scalar) else None
        if isinstance(value, bool) or not isinstance(value, int):
            what = f'`section` must be a section number, not {found(node)}'
            self._report.add(node.place, what, 'write for instance `section: 2`, or `[2, 3]`')
            return None
        if value < 1 or (last is not None and value > last):
            belt = f'from 1 to {last}' if last is not None else 'counted from 1'
            what = f'section {value} is not on the belt, whose sections are {belt}'
            hint = 'correct it, or leave `section` out for a component of no section'
            self._report.add(node.place, what, hint)
            return None
        return value

    # --- state topic ----------------------------------------------------------------------

    def _state(self) -> StateTopic | None:
        fields = self._fields.table('state')
        return None if fields is None else TopicReader(fields, self._types, self._report).topic()

    # --- simulation -----------------------------------------------------------------------

    def _durations(self) -> dict[str, float]:
        node = self._fields.mapping('durations')
        durations = {}
        for entry in node.entries if node else ():
            self._check_task(entry.key)
            value = entry.value.value if isinstance(entry.value, Scalar) else None
            if isinstance(value, bool) or not isinstance(value, (int, float)):
                what = f'a duration must be a number of seconds, not {found(entry.value)}'
                self._report.add(entry.value.place, what, f'write `{entry.key.text}: 1.0`')
            elif not 0 <= value <= LONGEST_SECONDS:
                what = (
                    f'a duration must be from 0 to {LONGEST_SECONDS:.0f}, not {found(entry.value)}'
                )
                self._report.add(entry.value.place, what, f'write `{entry.key.text}: 1.0`')
            else:
                durations[entry.key.text] = float(value)
        return durations

    def _results(self) -> Mapping[str, Mapping[str, Any]]:
        node = self._fields.mapping('results')
        results = {}
        for entry in node.entries if node else ():
            self._check_task(entry.key)
            if not isinstance(entry.value, MapNode):
                what = f'simulated results must be a mapping of fields, not {found(entry.value)}'
                hint = f'write `{entry.key.text}: {{measurement: 1.5}}`'
                self._report.add(entry.value.place, what, hint)
            elif self._type is not None:
                fields = self._type.result.fields
                message = MessageType(f'the result of {self._type.name}', fields)
                results[entry.key.text] = MessageReader(self._report).read(entry.value, message)
        return results

    def _faults(self) -> Iterator[Fault]:
        for item in self._fields.items('faults'):
            if not isinstance(item, Scalar) or item.value is None:
                what = f'a fault must be text, not {found(item)}'
                self._report.add(item.place, what, 'write it in quotes: "TASK_A#2=abort"')
                continue
            try:
                fault = parse_fault(item.text)
            except ValueError as error:
                self._report.add(item.place, str(error), 'write for instance "TASK_A#2=late:3.5"')
            else:
                self._check_fault(fault, item)
                yield fault

    def _check_fault(self, fault: Fault, item: Scalar) -> None:
        if self._type is not None:
            has_state = self._fields.has('state')
            for reason in unseen(fault, self._name, self._type, has_state=has_state):
                self._report.add(item.place, reason.what, reason.hint)

    def _check_task(self, key: Scalar) -> None:
        if self._type is not None:
            check_task_name(key.text, self._type, key.place, self._report)


class TopicReader:
    """Reads a topic with a field and its good values: of a state, or of the safety input."""

    def __init__(self, fields: Fields, types: ActionTypes, report: Report) -> None:
        self._fields = fields
        self._types = types
        self._report = report

    def topic(self) -> StateTopic:
        """Return the topic."""
        texts = (self._fields.text(key) for key in ('topic', 'type', 'field'))
        topic, type_name, field = texts
        if topic is not None:
            check_topic_name(topic, self._fields.place('topic'), self._report)
        known = self._field(type_name, field) if type_name and field else None
        return StateTopic(topic or '', type_name or '', field or '', self._ready(known))

    def _field(self, type_name: str, field: str) -> FieldType | None:
        place = self._fields.place('type')
        if not check_type_name(type_name, 'msg', place, self._report):
            return None
        try:
            ros_name = self._types.message_field(type_name, field)
        except UnknownActionType as fault:
            blamed = 'field' if ' field ' in fault.what else 'type'
            self._report.add(self._fields.place(blamed), fault.what, fault.hint)
            return None
        known = simple_type(ros_name)
        if known is None:
            what = f'the field `{field}` of {type_name} is {ros_name}, not one plain value'
            self._report.add(self._fields.place('field'), what, 'name a field of a simple type')
        return known

    def _ready(self, known: FieldType | None) -> tuple[Any, ...]:
        values: list[Any] = []
        items = self._fields.items('ready')
        if not items and self._fields.has('ready') and self._fields.is_sure('ready'):
            what = '`ready` is empty, so no goal would ever be sent'
            self._report.add(
                self._fields.place('ready'), what, 'list the values that allow a goal'
            )
        for item in items:
            value: Any = item.value if isinstance(item, Scalar) else item
            problem = misfit(value, known) if known else None
            if problem is not None:
                what = f'`ready` must be {problem.needed}, not {found(item)}'
                self._report.add(item.place, what, problem.hint)
            values.append(value)
        return tuple(values)
