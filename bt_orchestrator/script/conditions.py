"""`when` and `unless` (semantics 6.5)."""

from __future__ import annotations

from typing import Any

from bt_orchestrator.model.action_type import FieldType
from bt_orchestrator.model.reference import Template
from bt_orchestrator.model.script import Condition
from bt_orchestrator.script.checks.references import ReferenceReader
from bt_orchestrator.script.drafts import TaskDraft
from bt_orchestrator.script.field_types import misfit
from bt_orchestrator.script.fields import Fields
from bt_orchestrator.script.references import has_reference
from bt_orchestrator.script.report import Place, Report
from bt_orchestrator.script.task_keys import CONDITION
from bt_orchestrator.script.type_matching import in_words
from bt_orchestrator.script.yaml_nodes import MapNode, Node, Scalar, found, quoted

_HINT = 'write `"${...}"`, or `{value: "${...}", equals: ...}`'


class ConditionReader:
    """Reads the condition of one task.

    It must refer to something: without a reference it would always skip or never.
    """

    def __init__(self, task: TaskDraft, references: ReferenceReader, report: Report) -> None:
        self._task = task
        self._references = references
        self._report = report

    def read(self) -> Condition | None:
        """Return the condition; None if there is none or it is wrong."""
        when = self._read('when')
        unless = self._read('unless')
        return when or unless

    def _read(self, key: str) -> Condition | None:
        node = self._task.fields.value(key)
        if isinstance(node, MapNode):
            return self._comparison(key, node)
        if isinstance(node, Scalar):
            return self._boolean(key, node)
        if node is not None:
            what = f'`{key}` must be a reference or a comparison, not {found(node)}'
            self._report.add(node.place, what, _HINT)
        return None

    def _boolean(self, key: str, node: Scalar) -> Condition | None:
        read = self._template(key, node)
        if read is None:
            return None
        template, type_ = read
        if type_ is not None and (type_.kind != 'bool' or type_.is_array):
            text = str(template)
            what = f'`{key}` must be a boolean, but {quoted(text)} is {in_words(type_)}'
            hint = f'compare it: `{key}: {{value: "{text}", equals: ...}}`'
            self._report.add(node.place, what, hint)
        return Condition(template, negated=key == 'unless')

    def _comparison(self, key: str, node: MapNode) -> Condition | None:
        fields = Fields(node, CONDITION, self._report)
        value, equals = fields.value('value'), fields.value('equals')
        read = self._template('value', value) if isinstance(value, Scalar) else None
        if value is not None and not isinstance(value, Scalar):
            self._report.add(value.place, f'`value` must be text, not {found(value)}', _HINT)
        if equals is None:
            return None
        place = value.place if value else equals.place
        if read is None:
            self._compared(Template(()), None, equals, place)
            return None
        template, type_ = read
        compared = self._compared(template, type_, equals, place)
        return Condition(template, compared, negated=key == 'unless')

    def _template(self, key: str, node: Scalar) -> tuple[Template, FieldType | None] | None:
        if has_reference(node):
            return self._references.template(node)
        what = f'`{key}` refers to nothing, so it could not change: {found(node)}'
        self._report.add(node.place, what, _HINT)
        return None

    def _compared(
        self, template: Template, type_: FieldType | None, equals: Node, place: Place
    ) -> Any:
        """Return the value that is compared with, of the type of the reference."""
        value: Any = equals.value if isinstance(equals, Scalar) else equals
        if isinstance(equals, Scalar) and has_reference(equals):
            what = '`equals` must be a plain value, not a reference'
            self._report.add(equals.place, what, 'put the reference into `value`')
        elif type_ is not None and (type_.is_array or type_.kind == 'message'):
            what = f'{quoted(str(template))} is {in_words(type_)} and cannot be compared'
            self._report.add(place, what, 'refer to one of its fields')
        elif type_ is not None and (problem := misfit(value, type_)):
            what = f'`equals` must be {problem.needed}, not {found(equals)}'
            self._report.add(equals.place, what, problem.hint)
        elif not isinstance(equals, Scalar):
            what = f'`equals` must be a plain value, not {found(equals)}'
            self._report.add(equals.place, what, 'write text, a number, true or false')
        return value
