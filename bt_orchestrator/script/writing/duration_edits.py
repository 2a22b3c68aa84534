"""New nominal times in the text of a cell file, with everything else as it was written."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.model.cell import CONVEYOR
from bt_orchestrator.script.composing import compose
from bt_orchestrator.script.report import Place, Report
from bt_orchestrator.script.yaml_nodes import MapNode, Node, Scalar


class NotEditable(OrchestratorError):
    """The form of a cell file does not let a program change one duration alone."""


class _Edit(NamedTuple):
    """A piece of text in place of another one."""

    place: Place
    old: str
    """The present text; empty: the new text comes in front of it."""
    new: str


def with_durations(text: str, file: str, new: Mapping[str, Mapping[str, float]]) -> str:
    """Return the text of a cell file with other durations.

    :param new: seconds by component and task constant; of the conveyor one alone
    :raises NotEditable: the place of a duration is not its own, as with an alias
    """
    root = compose(text, Report(file))
    edits: dict[Place, _Edit] = {}
    for component, durations in new.items():
        node = _node_of(root, component)
        if node is None:
            what = f'{file}: component {component} is not written out here'
            raise NotEditable(f'{what}; change its durations by hand')
        for edit in _edits(node, component, durations, text):
            known = edits.get(edit.place)
            if known is not None and known != edit:
                raise NotEditable(
                    f'{file}:{edit.place.line}: what stands here is used more than once (an '
                    f'alias), and would need two values; write the durations of {component} out'
                )
            edits[edit.place] = edit
    rows = text.split('\n')
    for place in sorted(edits, key=lambda place: (place.line, place.column), reverse=True):
        _apply(rows, edits[place], file)
    return '\n'.join(rows)


def seconds_text(seconds: float) -> str:
    """Write a duration as in a cell file: 1.5, 2.0, 0.35."""
    text = f'{seconds:.6f}'.rstrip('0')
    return f'{text}0' if text.endswith('.') else text


def _node_of(root: Node | None, component: str) -> MapNode | None:
    if not isinstance(root, MapNode):
        return None
    if component == CONVEYOR:
        return _mapping(root, CONVEYOR)
    components = _mapping(root, 'components')
    return None if components is None else _mapping(components, component)


def _mapping(node: MapNode, key: str) -> MapNode | None:
    entry = node.find(key)
    return entry.value if entry is not None and isinstance(entry.value, MapNode) else None


def _edits(
    node: MapNode, component: str, durations: Mapping[str, float], text: str
) -> Iterator[_Edit]:
    if component == CONVEYOR:
        for seconds in durations.values():
            yield from _set(node, {'duration': seconds}, text)
        return
    known = _mapping(node, 'durations')
    if known is not None:
        yield from _set(known, durations, text)
    else:
        yield _added(node, f'durations: {{{_listed(durations)}}}', text)


def _set(node: MapNode, values: Mapping[str, float], text: str) -> Iterator[_Edit]:
    missing = {}
    for key, seconds in values.items():
        entry = node.find(key)
        if entry is None:
            missing[key] = seconds
        elif isinstance(entry.value, Scalar):
            yield _Edit(entry.value.place, entry.value.text, seconds_text(seconds))
    if missing:
        yield _added(node, _listed(missing), text)


def _listed(values: Mapping[str, float]) -> str:
    return ', '.join(f'{key}: {seconds_text(seconds)}' for key, seconds in values.items())


def _added(node: MapNode, what: str, text: str) -> _Edit:
    """Return the edit that puts a key in front of the first one of a mapping."""
    row = text.split('\n')[node.place.line - 1]
    place = node.place
    if row[place.column - 1 : place.column] == '{':
        inside = Place(place.line, place.column + 1)
        return _Edit(inside, '', f'{what}, ' if node.entries else what)
    first = node.entries[0].key.place
    indent = ' ' * (first.column - 1)
    lines = what if what.startswith('durations') else what.replace(', ', f'\n{indent}')
    return _Edit(first, '', f'{lines}\n{indent}')


def _apply(rows: list[str], edit: _Edit, file: str) -> None:
    line, column = edit.place.line - 1, edit.place.column - 1
    row = rows[line]
    if not row.startswith(edit.old, column):
        raise NotEditable(
            f'{file}:{edit.place.line}: expected {edit.old} here, found {row.strip()}; change the '
            f'duration to {edit.new} by hand'
        )
    rows[line] = f'{row[:column]}{edit.new}{row[column + len(edit.old) :]}'
