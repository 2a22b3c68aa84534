"""Reading what one component can do, against its action type."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from bt_orchestrator.model.action_type import TASK, TASK_RESULT, ActionType, FieldType
from bt_orchestrator.model.cell import Capability, Preparation
from bt_orchestrator.model.reference import Reference
from bt_orchestrator.model.script import Task
from bt_orchestrator.script.capabilities.capability_keys import CAPABILITY
from bt_orchestrator.script.capabilities.setups import read_setup
from bt_orchestrator.script.checks.balance import check_unjudged
from bt_orchestrator.script.checks.references import ReferenceReader
from bt_orchestrator.script.checks.structure import circles
from bt_orchestrator.script.drafts import Position, ScriptDraft, TaskDraft
from bt_orchestrator.script.fields import Fields, broken_limit, fields_of
from bt_orchestrator.script.names import check_id, check_name
from bt_orchestrator.script.references import Path, ReferenceFault, fixed_reference
from bt_orchestrator.script.report import Report, did_you_mean, listing
from bt_orchestrator.script.task_names import read_task_name
from bt_orchestrator.script.task_reader import check_works_on_belt, read_id, written_options
from bt_orchestrator.script.task_values import goal_arguments, read_serial
from bt_orchestrator.script.yaml_nodes import Entry, MapNode, Scalar, found, quoted

NO_FIELD = 'none'
"""In `needs`: the device that holds the thing is asked, and no goal field takes it."""


_NO_SETUPS: Mapping[str, Collection[str]] = {}


class CapabilityReader:
    """Reads capabilities, workspaces and preparation of one component."""

    def __init__(
        self,
        component: Fields,
        name: str,
        type_: ActionType | None,
        setups: Mapping[str, Collection[str]] = _NO_SETUPS,
    ) -> None:
        """Begin.

        :param setups: of the component, with their values
        """
        self._component, self._setups = component, setups
        self._name = name
        self._type = type_
        self._report = component.report

    def capabilities(self) -> Iterator[Capability]:
        """Yield what the component can do."""
        node = self._component.mapping('capabilities')
        for entry in (*node.entries, *node.repeated) if node else ():
            check_id(entry.key.text, 'capability name', entry.key.place, self._report)
            fields = fields_of(entry.value, CAPABILITY, self._report)
            if fields is not None:
                yield self._capability(entry.key.text, fields)

    def workspaces(self, sections: tuple[int, ...]) -> tuple[str, ...]:
        """Return where it works; a component that stands in one section needs not say it."""
        names: list[str] = []
        items = self._component.items('workspaces')
        for item in items:
            text = item.text if isinstance(item, Scalar) else ''
            if not text:
                what = f'a workspace must be a name, not {found(item)}'
                self._report.add(item.place, what, 'write for instance `workspaces: [left]`')
            elif text in names:
                what = f'the workspace {quoted(text)} is given twice'
                self._report.add(item.place, what, 'remove one')
            elif check_name(text, 'workspace', item.place, self._report):
                names.append(text)
        if not items and self._component.is_sure('workspaces', 'section'):
            self._check_workspaces(sections)
        return tuple(names)

    def preparation(self) -> Preparation | None:
        """Return how the component is made ready."""
        fields = self._component.table('prepare')
        if fields is None:
            return None
        return Preparation(
            id=read_id(fields) or '',
            task=self._task(fields, f'the preparation of `{self._name}` needs the key `task`'),
            after=tuple(name.text for name in fields.names('after')),
            args=self._args(fields, 'order'),
            options=written_options(fields),
        )

    def _check_workspaces(self, sections: tuple[int, ...]) -> None:
        has_own = self._component.has('workspaces')
        if not has_own and (len(sections) == 1 or not self._component.has('capabilities')):
            return
        what = '`workspaces` is empty'
        if not has_own:
            where = 'in several sections' if sections else 'in any section'
            what = f'`{self._name}` may work {where}, so its workspaces must be named'
        place = self._component.place('workspaces')
        self._report.add(place, what, 'write for instance `workspaces: [left]`')

    def _capability(self, name: str, fields: Fields) -> Capability:
        check_works_on_belt(fields)
        goal = dict(self._type.goal.fields) if self._type else None
        result = dict(self._type.result.fields) if self._type else None
        if goal is not None:
            goal.pop(TASK, None)
        if result is not None:
            result.pop(TASK_RESULT, None)
        capability = Capability(
            name=name,
            task=self._task(fields, f'the capability `{name}` needs the key `task`'),
            args=self._args(fields, 'order', 'item'),
            parameters=self._named(fields, 'parameters', goal),
            gives=self._named(fields, 'gives', result),
            needs=self._named(fields, 'needs', goal),
            holds=self._holds(fields),
            options=written_options(fields) | self._identifies(fields) | self._setup(fields),
        )
        self._check_once(fields, capability)
        return capability

    def _identifies(self, fields: Fields) -> dict[str, tuple[str, ...]]:
        """Return the result field that is the item's serial, if it reads one."""
        change = fields.whole('qty_change')
        if change:
            does = 'places the item' if change > 0 else 'takes the item out'
            check_unjudged(fields, does, self._report)
        task = TaskDraft(Task('', '', '', ''), fields, Position(1, 0, 0, 0), None, self._type)
        references = ReferenceReader(ScriptDraft(fields), task, self._report, of_verdict=True)
        serial = read_serial(task, references, self._report)
        return {'identifies': serial} if serial else {}

    def _setup(self, fields: Fields) -> dict[str, dict[str, str]]:
        """Return the values of setups that it asks for, if it asks for any."""
        asked = read_setup(fields, self._name, self._setups)
        return {'setup': asked} if asked else {}

    def _task(self, fields: Fields, missing: str) -> str:
        if self._type is None:
            return fields.text('task') or ''
        return read_task_name(fields, self._type, missing)

    def _args(self, fields: Fields, *sources: str) -> dict[str, Any]:
        references = _CellReferences(fields, sources)
        return goal_arguments(fields, self._type, references, self._report)

    # --- names of fields --------------------------------------------------------------------

    def _named(
        self, fields: Fields, key: str, known: Mapping[str, FieldType] | None
    ) -> dict[str, str]:
        """Return the fields that names stand for."""
        node = fields.mapping(key)
        named = {}
        for entry in (*node.entries, *node.repeated) if node else ():
            check_name(entry.key.text, 'name', entry.key.place, self._report)
            field = self._field(entry, key, known)
            if field is not None:
                named[entry.key.text] = field
        return named

    def _field(self, entry: Entry, key: str, known: Mapping[str, FieldType] | None) -> str | None:
        text = entry.value.text if isinstance(entry.value, Scalar) else ''
        kind = 'result' if key == 'gives' else 'goal'
        if not text:
            what = f'`{key}` names a {kind} field for each name, not {found(entry.value)}'
            self._report.add(entry.value.place, what, CAPABILITY.by_name[key].hint)
            return None
        if key == 'needs' and text == NO_FIELD:
            return ''
        if known is not None and text not in known:
            assert self._type is not None
            message = self._type.result if key == 'gives' else self._type.goal
            offered = f'its fields are {listing(known)}' if known else 'it has no fields'
            what = f'{message.name} has no field {quoted(text)}'
            if text in message.fields:
                what = f'the field `{text}` of {message.name} cannot be named'
            self._report.add(entry.value.place, what, did_you_mean(text, known, offered))
            return None
        return text

    def _holds(self, fields: Fields) -> dict[str, int]:
        node = fields.mapping('holds')
        held = {}
        for entry in (*node.entries, *node.repeated) if node else ():
            check_name(entry.key.text, 'name', entry.key.place, self._report)
            value = entry.value.value if isinstance(entry.value, Scalar) else None
            key = CAPABILITY.by_name['holds']
            if isinstance(value, bool) or not isinstance(value, int) or broken_limit(key, value):
                what = f'`holds` needs the number of items, at least 1, not {found(entry.value)}'
                self._report.add(entry.value.place, what, key.hint)
            else:
                held[entry.key.text] = value
        return held

    def _check_once(self, fields: Fields, capability: Capability) -> None:
        """Report fields that would be set twice, and things that are given twice."""
        owners: dict[str, str] = {}
        for key in ('parameters', 'needs'):
            for entry in _entries(fields, key):
                field = getattr(capability, key).get(entry.key.text)
                first = owners.setdefault(field, entry.key.text) if field else None
                if first is not None and first != entry.key.text:
                    what = f'the field `{field}` is set by `{first}` and by `{entry.key.text}`'
                    self._report.add(entry.value.place, what, 'remove one of them')
        for key, other in (('needs', 'parameters'), ('holds', 'gives')):
            for entry in _entries(fields, key):
                if entry.key.text in getattr(capability, other):
                    what = f'`{entry.key.text}` stands in `{other}` and in `{key}`'
                    self._report.add(entry.key.place, what, 'remove one of them')


class _CellReferences(ReferenceReader):
    """Reads references in a cell file, which knows neither parameters nor other tasks."""

    def __init__(self, fields: Fields, sources: tuple[str, ...]) -> None:
        nothing = TaskDraft(Task('', '', '', ''), fields, Position(1, 0, 0, 0), None, None)
        super().__init__(ScriptDraft(fields), nothing, fields.report)
        self._sources = sources

    def _find(self, written: Path) -> tuple[Reference, FieldType | None]:
        if written.source not in self._sources:
            what = f'{quoted(str(written))} cannot be used in a cell file'
            hint = f'use {" or ".join(f"`{source}`" for source in self._sources)}'
            if len(self._sources) > 1:
                hint = 'give the field a name with `parameters` or `needs`'
            raise ReferenceFault(what, hint)
        return fixed_reference(written)


def _entries(fields: Fields, key: str) -> tuple[Entry, ...]:
    node = fields.mapping(key)
    return node.entries if isinstance(node, MapNode) else ()


# Preparations of a cell against each other: their ids, and which comes first.


class Prepared(NamedTuple):
    """A component that is prepared."""

    component: str
    preparation: Preparation
    fields: Fields


def check_preparations(
    prepared: Sequence[Prepared], components: Collection[str], report: Report
) -> None:
    """Report ids given twice, waits for nothing, and preparations that wait for each other."""
    ids: dict[str, Prepared] = {}
    for entry in prepared:
        first = ids.setdefault(entry.preparation.id, entry)
        if first is not entry and entry.preparation.id:
            what = f'the id `{entry.preparation.id}` is given twice'
            line = first.fields.place('id').line
            hint = f'rename one; the first is in line {line}'
            report.add(entry.fields.place('id'), what, hint)
        _check_after(entry, prepared, components, report)
    waits = [(name, entry.component) for entry in prepared for name in entry.preparation.after]
    for circle in circles(waits):
        last = next(entry for entry in prepared if entry.component == circle[-1])
        what = f'preparations wait for each other: {", ".join(circle)}'
        report.add(last.fields.place('after'), what, 'remove one of the waits')


def _check_after(
    entry: Prepared, prepared: Sequence[Prepared], components: Collection[str], report: Report
) -> None:
    known = [other.component for other in prepared]
    for name in entry.fields.names('after'):
        if name.text in known:
            continue
        if name.text in components:
            what = f'`{name.text}` has no preparation to wait for'
            hint = f'give it `prepare`, or remove {quoted(name.text)} here'
        else:
            what = f'there is no component {quoted(name.text)}'
            hint = did_you_mean(
                name.text, components, f'those that are prepared are {listing(known)}'
            )
        report.add(name.place, what, hint)
