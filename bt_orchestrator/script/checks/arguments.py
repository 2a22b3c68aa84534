"""Goal arguments and simulated results: values in a file against the fields of a message type."""

from __future__ import annotations

from typing import Any, Protocol

from bt_orchestrator.model.action_type import FieldType, MessageType
from bt_orchestrator.model.reference import Template
from bt_orchestrator.script.field_types import Misfit, list_fits, misfit, needed_list
from bt_orchestrator.script.references import has_reference
from bt_orchestrator.script.report import Report, did_you_mean, listing
from bt_orchestrator.script.yaml_nodes import ListNode, MapNode, Node, Scalar, found, quoted


class Templates(Protocol):
    """Reads the strings that contain references."""

    def read(self, node: Scalar, name: str, needed: FieldType) -> Template | None:
        """Return the template of a string for a field; None if it is wrong (reported)."""


class MessageReader:
    """Reads a mapping as the fields of a message; what does not fit is reported and left out."""

    def __init__(self, report: Report, templates: Templates | None = None) -> None:
        self._report = report
        self._templates = templates

    def read(self, node: MapNode, message: MessageType, path: str = '') -> dict[str, Any]:
        """Return the fields with plain values; strings with references become Templates."""
        values = {}
        for entry in node.entries:
            name = entry.key.text
            if name in message.fields:
                values[name] = self.value(entry.value, message.fields[name], path + name)
            else:
                fields = listing(message.fields)
                otherwise = f'its fields are {fields}' if fields else 'remove it'
                hint = did_you_mean(name, message.fields, otherwise)
                what = f'{message.name} has no field {quoted(path + name)}'
                self._report.add(entry.key.place, what, hint)
        return values

    def value(self, node: Node, type_: FieldType, name: str) -> Any:
        """Return one field's value."""
        if isinstance(node, Scalar) and self._templates and has_reference(node):
            return self._templates.read(node, name, type_)
        if type_.is_array:
            return self._list(node, type_, name)
        if type_.message is not None:
            return self._message(node, type_.message, type_, name)
        return self._simple(node, type_, name)

    def _list(self, node: Node, type_: FieldType, name: str) -> list[Any] | None:
        if not isinstance(node, ListNode):
            self._refuse(node, name, Misfit(needed_list(type_), 'write [value, ...]'))
            return None
        if not list_fits(len(node.items), type_):
            what = f'`{name}` must be {needed_list(type_)}, not of {len(node.items)}'
            self._report.add(node.place, what, 'give it that length')
        member = member_type(type_)
        return [self.value(item, member, f'{name}[{n}]') for n, item in enumerate(node.items)]

    def _message(self, node: Node, message: MessageType, type_: FieldType, name: str) -> Any:
        if isinstance(node, MapNode):
            return self.read(node, message, f'{name}.')
        hint = f'write {{{", ".join(f"{field}: ..." for field in message.fields)}}}'
        self._refuse(node, name, Misfit(f'a mapping ({type_.ros_name})', hint))
        return None

    def _simple(self, node: Node, type_: FieldType, name: str) -> Any:
        value: Any = node.value if isinstance(node, Scalar) else node
        problem = misfit(value, type_)
        if problem is not None:
            self._refuse(node, name, problem)
            return None
        return float(value) if type_.kind == 'float' else value

    def _refuse(self, node: Node, name: str, problem: Misfit) -> None:
        what = f'`{name}` must be {problem.needed}, not {found(node)}'
        self._report.add(node.place, what, problem.hint)


def member_type(type_: FieldType) -> FieldType:
    """Return the type of an array's members."""
    name = type_.message.name if type_.message else type_.ros_name.split('[', 1)[0]
    return FieldType(
        type_.kind,
        name,
        type_.minimum,
        type_.maximum,
        string_maximum=type_.string_maximum,
        message=type_.message,
    )
