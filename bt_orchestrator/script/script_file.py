"""Reading a script: how one product is made, checked against its cell (semantics 8.1)."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.jobs.setups import with_changes
from bt_orchestrator.model.script import (
    Dependency,
    InitializationDependency,
    MadeFrom,
    Repeat,
    Script,
    SectionList,
    Step,
    Zone,
)
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.script.capabilities.setups import check_setups
from bt_orchestrator.script.checks.balance import check_balance
from bt_orchestrator.script.checks.structure import DependencyReader, check_repeats, check_sections
from bt_orchestrator.script.conditions.likely import read_likely
from bt_orchestrator.script.declared import read_hold_after, read_parameters
from bt_orchestrator.script.drafts import ScriptDraft, SectionDraft
from bt_orchestrator.script.fields import Fields, file_fields
from bt_orchestrator.script.keys import Kind
from bt_orchestrator.script.names import check_id
from bt_orchestrator.script.report import Report
from bt_orchestrator.script.script_keys import MADE_FROM, SCRIPT
from bt_orchestrator.script.section_reader import SectionReader
from bt_orchestrator.script.source_text import read_text
from bt_orchestrator.script.task_reader import TaskReader
from bt_orchestrator.script.task_values import check_serials, complete_task, read_lots


def read_script(path: Path, cell: Cell, types: ActionTypes) -> Script:
    """Read a script for a cell and check everything that can be known without moving.

    :raises Refused: with every mistake in it
    """
    return parse_script(read_text(path), str(path), cell, types)


def parse_script(text: str, file: str, cell: Cell, types: ActionTypes) -> Script:
    """Read the text of a script; the file's name stands in the findings.

    :raises Refused: with every mistake in it
    """
    report = Report(file)
    fields = file_fields(text, SCRIPT, report)
    script = _ScriptReader(fields, cell, types, report).read()
    report.refuse()
    return script


@dataclass(frozen=True)
class _Relations:
    lateral: tuple[Dependency, ...]
    zones: tuple[Zone, ...]
    initialization: tuple[InitializationDependency, ...]


class _ScriptReader:
    """Reads one script in three passes: the tasks, what refers to tasks, the script as a whole."""

    def __init__(self, fields: Fields, cell: Cell, types: ActionTypes, report: Report) -> None:
        self._fields = fields
        self._cell = cell
        self._types = types
        self._report = report
        self._draft = ScriptDraft(fields)

    def read(self) -> Script:
        """Return the script; it is of use only if nothing was reported."""
        name = self._fields.text('script')
        if name is not None:
            check_id(name, 'script name', self._fields.place('script'), self._report)
        quantity = self._fields.optional_whole('quantity')
        read_parameters(self._draft, self._report)
        tasks = TaskReader(self._cell, self._types, self._report)
        sections = self._cell.conveyor.sections
        SectionReader(self._draft, tasks, sections, self._report).read()
        relations = self._relations()
        check_balance(self._draft, self._report)
        check_sections(self._draft, self._report)
        check_repeats(self._draft, self._report)
        check_serials(self._draft.listed, self._report)
        script = self._script(name or '', quantity, relations)
        check_setups(script, self._draft, self._report)
        return script if self._report.findings else with_changes(script, self._cell)

    def _relations(self) -> _Relations:
        reader = DependencyReader(self._draft, self._report)
        return _Relations(tuple(reader.lateral()), tuple(reader.zones()), reader.initialization())

    def _script(self, name: str, quantity: int | None, relations: _Relations) -> Script:
        draft = self._draft
        sections = {n: self._section(draft.sections[n]) for n in sorted(draft.sections)}
        conditions = {
            task.id: task.condition for section in sections.values() for task in section.tasks
        }
        return Script(
            name=name,
            sections=sections,
            initialization=tuple(
                complete_task(draft, task, self._report) for task in draft.initialization
            ),
            initialization_dependencies=relations.initialization,
            dependencies=relations.lateral,
            zones=relations.zones,
            params=draft.params,
            quantity=quantity,
            made_from=read_origin(self._fields),
            repeats=tuple(
                Repeat(tuple(task.id for task in repeat.tasks), repeat.times)
                for repeat in draft.repeats
                if repeat.tasks
            ),
            lots=read_lots(draft, self._report),
            likely=read_likely(draft.listed, conditions, self._report),
            hold_after=read_hold_after(self._fields),
            first_piece=self._fields.switch('first_piece'),
        )

    def _section(self, section: SectionDraft) -> SectionList:
        steps = tuple(
            Step(
                tuple(
                    tuple(complete_task(self._draft, task, self._report) for task in track)
                    for track in step
                )
            )
            for step in section.steps
        )
        return SectionList(section.section, steps, section.release)


# The key `made_from`: where a generated script comes from.

_TEXTS = tuple(key.name for key in MADE_FROM.keys if key.kind is Kind.TEXT)


def read_origin(script: Fields) -> MadeFrom | None:
    """Return what a script was made from; None: it was written by hand."""
    fields = script.table('made_from')
    if fields is None:
        return None
    texts = {name: fields.text(name) or '' for name in _TEXTS}
    without = tuple(name.text for name in fields.names('without'))
    return MadeFrom(version=fields.optional_whole('version') or 0, without=without, **texts)
