"""`when`, `unless` and `fails_unless` (semantics 2.8, 6.5)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from bt_orchestrator.model.action_type import FieldType
from bt_orchestrator.model.condition import Condition
from bt_orchestrator.model.reference import Template
from bt_orchestrator.script.checks.references import ReferenceReader
from bt_orchestrator.script.conditions.condition_keys import COMPARISONS, CONDITION, PARTS
from bt_orchestrator.script.drafts import TaskDraft
from bt_orchestrator.script.field_types import PARAMETER_TYPES, in_words, misfit
from bt_orchestrator.script.fields import Fields
from bt_orchestrator.script.references import Path, has_reference, split
from bt_orchestrator.script.report import Place, Report, listing
from bt_orchestrator.script.yaml_nodes import MapNode, Node, Scalar, found, quoted

_HINT = 'write `"${...}"`, or `{value: "${...}", equals: ...}`'
_BOUNDS = ['at_least', 'at_most']


class ConditionReader:
    """Reads the condition of one task, or its verdict, whose references know its own results.

    Each must refer to something: without a reference it would always skip or never.
    """

    def __init__(self, task: TaskDraft, references: ReferenceReader, report: Report) -> None:
        self._task = task
        self._references = references
        self._report = report
        self._operands = OperandReader(references, report)

    def read(self) -> Condition | None:
        """Return the condition; None if there is none or it is wrong."""
        fields = self._task.fields
        if fields.has('when') and fields.has('unless'):
            what = 'a task has either `when` or `unless`, not both'
            self._report.add(fields.key_place('unless'), what, 'keep one of them')
        when, unless = self._read('when'), self._read('unless')
        return when or (unless and replace(unless, negated=True))

    def verdict(self) -> Condition | None:
        """Return the verdict; None if there is none or it is wrong.

        It must name a result of its task: it would otherwise judge what was known before.
        """
        mistakes = len(self._report.findings)
        verdict = self._read('fails_unless')
        if verdict is None or len(self._report.findings) > mistakes:
            return verdict
        task = self._task.task
        if not any(map(task.gives, verdict.references)):
            what = f'`fails_unless` names no result of `{task.id}`, which it is to judge'
            hint = f'refer to `${{results.{task.id}.FIELD}}`; for what is known before, use `when`'
            self._report.add(self._task.place('fails_unless'), what, hint)
        return verdict

    def _read(self, key: str) -> Condition | None:
        node = self._task.fields.value(key)
        return None if node is None else self._condition(key, node, f'{key}: ')

    def _condition(self, name: str, node: Node, before: str = '') -> Condition | None:
        """Read a condition, or a part of one.

        :param before: what stands before it where it is written
        """
        if isinstance(node, MapNode):
            return self._mapping(node)
        if isinstance(node, Scalar):
            return self._boolean(name, node, before)
        what = f'`{name}` must be a reference or a comparison, not {found(node)}'
        self._report.add(node.place, what, _HINT)
        return None

    def _boolean(self, name: str, node: Scalar, before: str) -> Condition | None:
        read = self._compared(name, node)
        if read is None:
            return None
        if read.type is not None and (read.type.kind != 'bool' or read.type.is_array):
            text = str(read.template)
            what = f'`{name}` must be a boolean, but {quoted(text)} is {in_words(read.type)}'
            comparison = 'at_least' if read.type.kind == 'float' else 'equals'
            hint = f'compare it: `{before}{{value: "{text}", {comparison}: ...}}`'
            self._report.add(node.place, what, hint)
        return Condition(read.template)

    def _mapping(self, node: MapNode) -> Condition | None:
        fields = Fields(node, CONDITION, self._report)
        given = [key for key in (*COMPARISONS, *PARTS) if fields.has(key)]
        if not given:
            if fields.is_sure(*COMPARISONS, *PARTS):
                what = f'a condition needs one of {listing((*COMPARISONS, *PARTS), longest=8)}'
                self._report.add(node.place, what, CONDITION.by_name['equals'].hint)
            if fields.has('value'):
                self._value(fields)
            return None
        for key in given[1:]:
            what = f'a condition has one comparison, not `{given[0]}` and `{key}`'
            hint = 'write `all: [...]` with a condition for each'
            if [given[0], key] == _BOUNDS:
                hint = 'write `between: [LOWEST, HIGHEST]`'
            self._report.add(fields.key_place(key), what, hint)
        read = self._joint if given[0] in PARTS else self._comparison
        return read(given[0], fields)

    def _joint(self, key: str, fields: Fields) -> Condition | None:
        if fields.has('value'):
            what = f'`value` stands beside `{key}`, which is made of conditions'
            self._report.add(fields.key_place('value'), what, 'remove it')
        items = fields.items(key)
        if not items and fields.is_sure(key):
            what = f'`{key}` has no conditions'
            self._report.add(fields.place(key), what, CONDITION.by_name[key].hint)
        parts = [self._condition(f'{key}[{n}]', item) for n, item in enumerate(items)]
        whole = tuple(part for part in parts if part is not None)
        return Condition(all=whole) if key == 'all' else Condition(any=whole)

    def _comparison(self, key: str, fields: Fields) -> Condition | None:
        value = self._value(fields)
        node = fields.value(key)
        if node is None or (value and not self._operands.fits(key, node, value)):
            return None
        type_ = value.type if value else None
        operands: dict[str, Any] = {}
        if key == 'between':
            operands = dict(zip(_BOUNDS, self._between(fields, type_), strict=False))
        elif key == 'one_of':
            operands['one_of'] = self._one_of(fields, type_)
        else:
            read = self._operands.bound if key in _BOUNDS else self._operands.plain
            operands[key] = read(key, node, type_)
        return value and Condition(value.template, **operands)

    def _between(self, fields: Fields, type_: FieldType | None) -> list[Any]:
        items = fields.items('between')
        if len(items) != 2 and fields.is_sure('between'):
            what = f'`between` needs two bounds, not {len(items)}'
            self._report.add(fields.place('between'), what, CONDITION.by_name['between'].hint)
        return self._operands.bounds('between', items, type_)

    def _one_of(self, fields: Fields, type_: FieldType | None) -> tuple[Any, ...]:
        items = fields.items('one_of')
        if not items and fields.is_sure('one_of'):
            what = '`one_of` has no values'
            self._report.add(fields.place('one_of'), what, CONDITION.by_name['one_of'].hint)
        each = enumerate(items)
        return tuple(self._operands.plain(f'one_of[{n}]', item, type_) for n, item in each)

    def _value(self, fields: Fields) -> Compared | None:
        """Return what is compared; None if it is wrong, or not there (reported)."""
        node = fields.value('value')
        if isinstance(node, Scalar):
            return self._compared('value', node)
        if node is not None:
            self._report.add(node.place, f'`value` must be text, not {found(node)}', _HINT)
        elif fields.is_sure('value'):
            what = 'a condition needs the key `value`'
            self._report.add(fields.node.place, what, CONDITION.by_name['value'].hint)
        return None

    def _compared(self, name: str, node: Scalar) -> Compared | None:
        if has_reference(node):
            read = self._references.template(node)
            return read and Compared(*read, node.place)
        what = f'`{name}` refers to nothing, so it could not change: {found(node)}'
        self._report.add(node.place, what, _HINT)
        return None


# The operand that the value of a condition is compared with (semantics 6.5).

NUMBERS = ('int', 'float')
"""Kinds that have an order."""


class Compared(NamedTuple):
    """The value of a condition."""

    template: Template
    type: FieldType | None
    """None: not known."""
    place: Place

    @property
    def named(self) -> str:
        """It and its type, for a message."""
        type_ = '' if self.type is None else f' is {in_words(self.type)}'
        return f'{quoted(str(self.template))}{type_}'


class OperandReader:
    """Reads plain values and bounds; nothing changes its type to be compared."""

    def __init__(self, references: ReferenceReader, report: Report) -> None:
        self._references = references
        self._report = report

    def fits(self, key: str, node: Node, compared: Compared) -> bool:
        """Tell whether a value of this type may be compared so; what is wrong is reported."""
        type_ = compared.type
        if type_ is None:
            return True
        if type_.is_array or type_.kind == 'message':
            what = f'{compared.named} and cannot be compared'
            self._report.add(compared.place, what, 'refer to one of its fields')
            return False
        if key in ('at_least', 'at_most', 'between') and type_.kind not in NUMBERS:
            what = f'`{key}` compares numbers, but {compared.named}'
            hint = 'compare it with `equals`, `not_equals` or `one_of`'
        elif key in ('equals', 'not_equals', 'one_of') and type_.kind == 'float':
            what = f'`{key}` compares exactly, but {compared.named}, and those are rarely equal'
            hint = 'compare it with `at_least`, `at_most` or `between`'
        else:
            return True
        self._report.add(node.place, what, hint)
        return False

    def plain(self, name: str, node: Node, type_: FieldType | None) -> Any:
        """Return a plain value, of the type of what is compared."""
        value: Any = node.value if isinstance(node, Scalar) else node
        if isinstance(node, Scalar) and has_reference(node):
            what = f'`{name}` must be a plain value, not a reference'
            self._report.add(node.place, what, 'put the reference into `value`')
        elif type_ is not None and (problem := misfit(value, type_)):
            what = f'`{name}` must be {problem.needed}, not {found(node)}'
            self._report.add(node.place, what, problem.hint)
        elif not isinstance(node, Scalar):
            what = f'`{name}` must be a plain value, not {found(node)}'
            self._report.add(node.place, what, 'write text, a number, true or false')
        return value

    def bound(self, name: str, node: Node, type_: FieldType | None) -> Any:
        """Return a number, or the Template of one parameter."""
        if not (isinstance(node, Scalar) and has_reference(node)):
            return self.plain(name, node, type_ or PARAMETER_TYPES['float'])
        parts = list(split(node.text))
        if len(parts) > 1 or (isinstance(parts[0], Path) and parts[0].source != 'params'):
            what = f'`{name}` must be a number or one parameter, not {found(node)}'
            self._report.add(node.place, what, 'write a number, or `"${params.NAME}"`')
            return None
        if type_ is not None:
            return self._references.read(node, name, type_)
        read = self._references.template(node)
        return read and read[0]

    def bounds(self, name: str, nodes: Sequence[Node], type_: FieldType | None) -> list[Any]:
        """Return the two bounds of `between`, the lower one first."""
        found_bounds = [self.bound(f'{name}[{n}]', node, type_) for n, node in enumerate(nodes)]
        if len(nodes) == 2 and are_crossed(*found_bounds):
            low, high = found_bounds
            what = f'no value is between {low} and {high}'
            self._report.add(nodes[0].place, what, 'write the lower bound first')
        return found_bounds


def are_crossed(low: object, high: object) -> bool:
    """Tell whether two bounds are numbers, and the wrong way round."""
    numbers = [bound for bound in (low, high) if isinstance(bound, (int, float))]
    return len(numbers) == 2 and numbers[0] > numbers[1]
