"""The operand that the value of a condition is compared with (semantics 6.5)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from bt_orchestrator.model.action_type import FieldType
from bt_orchestrator.model.reference import Template
from bt_orchestrator.script.checks.references import ReferenceReader
from bt_orchestrator.script.field_types import PARAMETER_TYPES, misfit
from bt_orchestrator.script.references import Path, has_reference, split
from bt_orchestrator.script.report import Place, Report
from bt_orchestrator.script.type_matching import in_words
from bt_orchestrator.script.yaml_nodes import Node, Scalar, found, quoted

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
    numbers = [one for one in (low, high) if isinstance(one, (int, float))]
    return len(numbers) == 2 and numbers[0] > numbers[1]
