"""Reading a cell file: what exists (formats: cell file)."""

from __future__ import annotations

from enum import Enum
from pathlib import Path

from bt_orchestrator.base.errors import Finding, Refused
from bt_orchestrator.model.cell import (
    CONVEYOR,
    Approval,
    Cell,
    Component,
    Conveyor,
    OnFailure,
    Release,
    SafetyInput,
    Start,
)
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.script.capabilities.capability_reader import Prepared, check_preparations
from bt_orchestrator.script.cell_keys import CELL, COMPONENT
from bt_orchestrator.script.component_reader import ComponentReader, TopicReader
from bt_orchestrator.script.composing import compose
from bt_orchestrator.script.declared import read_hold_after
from bt_orchestrator.script.fields import Fields, fields_of, file_fields
from bt_orchestrator.script.names import check_name
from bt_orchestrator.script.report import START, Report
from bt_orchestrator.script.ros_names import check_token
from bt_orchestrator.script.script_keys import SCRIPT
from bt_orchestrator.script.shape import refuse_strangers
from bt_orchestrator.script.source_text import read_text
from bt_orchestrator.script.yaml_nodes import Entry, MapNode

CELL_FILE = 'cell.yaml'
"""The cell file of a folder, where the user names no other."""


def read_cell(path: Path, types: ActionTypes) -> Cell:
    """Read a cell file.

    :raises Refused: with every mistake in it
    """
    return parse_cell(read_text(path), str(path), types)


def parse_cell(text: str, file: str, types: ActionTypes) -> Cell:
    """Read the text of a cell file; the file's name stands in the findings.

    :raises Refused: with every mistake in it
    """
    report = Report(file)
    cell = _CellReader(file_fields(text, CELL, report), report, types).cell()
    report.refuse()
    if cell is None:
        raise Refused(report.findings)
    return cell


class _CellReader:
    """Reads one cell file."""

    def __init__(self, fields: Fields, report: Report, types: ActionTypes) -> None:
        self._fields = fields
        self._report = report
        self._types = types
        self._lines: dict[str, tuple[str, int]] = {}
        self._known = {CONVEYOR}
        """Names of components, also of those that could not be read."""
        self._preparations: list[Prepared] = []

    def cell(self) -> Cell | None:
        """Return the cell; None if its conveyor could not be read."""
        name = self._fields.text('cell')
        if name:
            check_token(name, 'cell', self._fields.place('cell'), self._report)
        belt = self._fields.table('conveyor')
        conveyor = self._conveyor(belt) if belt else None
        sections = belt.whole('sections') if belt and belt.is_sure('sections') else None
        components = self._components(sections)
        check_preparations(self._preparations, self._known, self._report)
        if name is None or conveyor is None:
            return None
        start = Start(self._fields.choice('start'))
        release = Release(self._fields.choice('release'))
        components = {CONVEYOR: conveyor.component, **components}
        most_items, hold_after = self._fields.whole('most_items'), read_hold_after(self._fields)
        safety = self._safety()
        piece = Approval(self._fields.choice('first_piece'))
        return Cell(
            name,
            conveyor,
            components,
            start,
            release,
            most_items,
            hold_after,
            safety=safety,
            first_piece=piece,
        )

    def _safety(self) -> SafetyInput | None:
        fields = self._fields.table('safety')
        if fields is None:
            return None
        topic = TopicReader(fields, self._types, self._report).topic()
        return SafetyInput(**vars(topic), within_s=fields.seconds('within'))

    def _conveyor(self, fields: Fields) -> Conveyor:
        reader = ComponentReader(fields, CONVEYOR, self._report, self._types)
        component = reader.conveyor()
        self._note(component, fields)
        return Conveyor(
            sections=fields.whole('sections'),
            component=component,
            task=reader.index_task(),
            retries=fields.whole('retries'),
            on_failure=OnFailure(fields.choice('on_failure')),
        )

    def _components(self, sections: int | None) -> dict[str, Component]:
        node = self._fields.mapping('components')
        if node is not None and not node.entries and node.is_complete:
            what = 'a cell needs at least one component beside the conveyor'
            self._report.add(node.place, what, CELL.by_name['components'].hint)
        components = {}
        for entry in node.entries if node else ():
            component = self._component(entry, sections)
            if component is not None:
                components[component.name] = component
        for entry in node.repeated if node else ():
            self._component(entry, sections)
        return components

    def _component(self, entry: Entry, sections: int | None) -> Component | None:
        name = entry.key.text
        check_name(name, 'component name', entry.key.place, self._report)
        if name == CONVEYOR:
            what = f'a component cannot be named `{CONVEYOR}`: that is the belt itself'
            self._report.add(entry.key.place, what, 'choose another name')
        self._known.add(name)
        fields = fields_of(entry.value, COMPONENT, self._report)
        if fields is None:
            return None
        component = ComponentReader(fields, name, self._report, self._types).component(sections)
        self._note(component, fields)
        return component

    def _note(self, component: Component, fields: Fields) -> None:
        self._check_action(component, fields)
        prepare = fields.table('prepare')
        if prepare is not None and component.prepare is not None:
            self._preparations.append(Prepared(component.name, component.prepare, prepare))

    def _check_action(self, component: Component, fields: Fields) -> None:
        """Report a second component of one action name: a goal names only the action."""
        if not component.action:
            return
        line = fields.place('action').line
        first, first_line = self._lines.setdefault(component.action, (component.name, line))
        if first != component.name:
            what = (
                f'the action `{component.action}` already belongs to `{first}` (line {first_line})'
            )
            self._report.add(fields.place('action'), what, 'give each component its own action')


# Telling a user's cell file from a script, by what is in it.


class FileKind(Enum):
    """The subject of a file."""

    CELL = 'cell'
    SCRIPT = 'script'


def file_kind(path: Path) -> FileKind:
    """Tell what a file describes; its mistakes are reported by its reader.

    :raises Refused: it cannot be read, or describes neither
    """
    report = Report(str(path))
    text = read_text(path)
    root = compose(text, report)
    refuse_strangers(text, root, report, [CELL, SCRIPT], 'a cell file or a script')
    report.refuse()
    keys = {entry.key.text for entry in root.entries} if isinstance(root, MapNode) else set()
    if keys & {'conveyor', 'components'}:
        return FileKind.CELL
    if 'sections' in keys:
        return FileKind.SCRIPT
    what = 'this is neither a cell file nor a script'
    hint = 'a cell file has the keys `conveyor` and `components`, a script has `sections`'
    raise Refused([Finding(str(path), START.line, START.column, what, hint)])
