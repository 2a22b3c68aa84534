"""The identity and the contents of an item: `identifies` and `lots` (semantics 6.8, 6.9)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from bt_orchestrator.model.reference import Template
from bt_orchestrator.script.checks.references import ReferenceReader
from bt_orchestrator.script.drafts import ScriptDraft, TaskDraft
from bt_orchestrator.script.names import check_name
from bt_orchestrator.script.references import has_reference, is_single
from bt_orchestrator.script.report import Report
from bt_orchestrator.script.type_matching import in_words
from bt_orchestrator.script.yaml_nodes import Entry, Scalar, found, quoted

_NAMED = ('str', 'int')
"""Types of values that may name something."""


def read_serial(task: TaskDraft, references: ReferenceReader, report: Report) -> tuple[str, ...]:
    """Return the path of the result field that is the item's serial; empty: none, or wrong."""
    field = task.fields.text('identifies')
    if field is None:
        return ()
    place = task.place('identifies')
    if '${' in field:
        what = f'`identifies` is the name of a result field of `{task.id}`, not {quoted(field)}'
        report.add(place, what, 'write for instance `identifies: serial`')
        return ()
    read = references.own_field(place, field)
    if read is None:
        return ()
    reference, type_ = read
    if type_ is not None and (type_.kind not in _NAMED or type_.is_array):
        what = f'`identifies` must name text or a whole number, but `{field}` is {in_words(type_)}'
        report.add(place, what, 'name the field that has the serial')
    return reference.fields


def check_serials(tasks: Iterable[TaskDraft], report: Report) -> None:
    """Report a second task that identifies the item (semantics 6.8)."""
    reading = [task for task in tasks if task.identifies and not task.task.qty_change]
    for task in reading[1:]:
        first = reading[0]
        what = f'`{first.id}` (line {first.line}) identifies the item already'
        if task.fields.has('identifies'):
            report.add(task.fields.key_place('identifies'), what, 'keep one of them')
        else:
            hint = 'let `do` name a capability without `identifies`'
            report.add(task.place('do'), what, hint)


def read_lots(script: ScriptDraft, report: Report) -> dict[str, Template]:
    """Return what goes into each item, by name."""
    node = script.fields.mapping('lots')
    return dict(_lots(node.entries if node else (), ReferenceReader(script, None, report), report))


def _lots(
    entries: tuple[Entry, ...], references: ReferenceReader, report: Report
) -> Iterator[tuple[str, Template]]:
    for entry in entries:
        name, value = entry.key.text, entry.value
        check_name(name, 'lot name', entry.key.place, report)
        if not isinstance(value, Scalar) or not has_reference(value):
            what = f'`{name}` must refer to the order, but it is {found(value)}'
            hint = f'write for instance `{name}: "${{params.{name}_lot}}"`'
            report.add(value.place, what, hint)
            continue
        read = references.template(value)
        if read is None:
            continue
        template, type_ = read
        if is_single(template) and type_ is not None and type_.kind not in _NAMED:
            what = f'`{name}` must be text or a whole number, but {quoted(str(template))} is'
            report.add(value.place, f'{what} {in_words(type_)}', 'refer to a value of that type')
        yield name, template
