"""A script as the text of a file: what its reader makes the same script of."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from enum import Enum
from itertools import count
from typing import Any

from bt_orchestrator.model.cell import Cell, OnFailure
from bt_orchestrator.model.condition import Condition
from bt_orchestrator.model.script import (
    Dependency,
    MadeFrom,
    Parameter,
    Release,
    Script,
    SectionList,
    Step,
    Task,
)
from bt_orchestrator.script.keys import Key
from bt_orchestrator.script.task_keys import INITIALIZATION_TASK, TASK
from bt_orchestrator.script.writing.yaml_text import STEP, dashed, entry, item

COMMENT_WIDTH = 100


@dataclass(frozen=True)
class Comments:
    """The head of a script, above its lines."""

    head: Sequence[str] = ()
    """Paragraphs at the beginning of the file."""
    sections: Mapping[int, str] = field(default_factory=dict)
    tasks: Mapping[str, str] = field(default_factory=dict)
    """By the id of the task; initialization too."""
    flags: Mapping[str, str] = field(default_factory=dict)
    zones: Mapping[str, str] = field(default_factory=dict)


NO_COMMENTS = Comments()


def write_script(script: Script, cell: Cell | None, comments: Comments = NO_COMMENTS) -> str:
    """Return the text of a script, one line a task where it fits; equal scripts, equal texts.

    :param cell: the cell that it was read for; None: not known, so every time limit is written
    """
    return ''.join(f'{line}\n' for line in _ScriptWriter(script, cell, comments).lines())


class _ScriptWriter:
    """Writes one script, its keys in the order of the reference."""

    def __init__(self, script: Script, cell: Cell | None, comments: Comments) -> None:
        self._script, self._cell, self._comments = script, cell, comments

    def lines(self) -> Iterator[str]:
        """Yield the lines of the file."""
        script, comments = self._script, self._comments
        for paragraph in comments.head:
            yield from _comment(paragraph, '')
        yield from entry('script', script.name, '')
        if script.made_from is not None:
            yield from entry('made_from', _given(script.made_from), '')
        if script.quantity is not None:
            yield from entry('quantity', script.quantity, '')
        params = {param.name: _parameter_row(param) for param in script.params.values()}
        yield from _named('params', params, {})
        if script.lots:
            yield from entry('lots', script.lots, '')
        if script.hold_after is not None:
            yield from entry('hold_after', asdict(script.hold_after), '')
        if script.first_piece:
            yield from entry('first_piece', True, '')
        yield from self._initialization()
        yield 'sections:'
        for number in sorted(script.sections):
            yield from self._section(script.sections[number])
        yield from self._flags()
        yield from _named('zones', {z.name: z.tasks for z in script.zones}, comments.zones)

    def _initialization(self) -> Iterator[str]:
        ids = (f'init.{number}' for number in count(1))
        implied = {task.id for task in self._script.initialization if task.is_implied}
        written = [task for task in self._script.initialization if task.id not in implied]
        order = self._script.initialization_dependencies
        if written:
            yield 'initialization:'
        for task in written:
            yield from self._task(task, next(ids), STEP)
        if any(dependency.downstream not in implied for dependency in order):
            yield 'initialization_dependencies:'
        for dependency in order:
            if dependency.downstream in implied:
                continue
            yield from item(
                {'upstream': dependency.upstream, 'downstream': dependency.downstream}, STEP
            )

    def _section(self, section: SectionList) -> Iterator[str]:
        yield from _comment(self._comments.sections.get(section.section), STEP)
        yield f'{STEP}{section.section}:'
        indent = STEP * 2
        if section.release is not Release.END_OF_CYCLE:
            yield from entry('release_conveyor', section.release.value, indent)
            yield f'{indent}tasks:'
            indent += STEP
        ids = (f'{section.section}.{number}' for number in count(1))
        for step in section.steps:
            yield from self._step(step, ids, indent)

    def _step(self, step: Step, ids: Iterator[str], indent: str) -> Iterator[str]:
        if not step.is_group:
            yield from self._track(step.tracks[0], ids, indent)
            return
        yield f'{indent}- parallel:'
        for track in step.tracks:
            yield from self._track(track, ids, indent + STEP)

    def _track(self, track: Sequence[Task], ids: Iterator[str], indent: str) -> Iterator[str]:
        first, *others = track
        repeat = self._script.repeat_of.get(first.id)
        if repeat is not None:
            yield f'{indent}- repeat:'
            for task in track:
                yield from self._task(task, next(ids), indent + STEP)
            if repeat.times != 1:
                yield from entry('times', repeat.times, indent + STEP)
            return
        if not others:
            yield from self._task(first, next(ids), indent)
            return
        yield from self._above(first, indent)
        yield from dashed(self._plain_task(first, next(ids), indent + STEP), indent)
        for task in others:
            yield from self._task(task, next(ids), indent + STEP)

    def _task(self, task: Task, default_id: str, indent: str) -> Iterator[str]:
        yield from self._above(task, indent)
        yield from self._plain_task(task, default_id, indent)

    def _above(self, task: Task, indent: str) -> Iterator[str]:
        return _comment(self._comments.tasks.get(task.id), indent)

    def _plain_task(self, task: Task, default_id: str, indent: str) -> Iterator[str]:
        row, likely = task_row(task, self._cell, default_id), self._script.likely.get(task.id)
        if likely is not None:
            row['likely'] = {
                name: share for name, share in vars(likely).items() if share is not None
            }
        return item(row, indent)

    def _flags(self) -> Iterator[str]:
        if self._script.dependencies:
            yield 'lateral_dependencies:'
        for flag in self._script.dependencies:
            yield from _comment(self._comments.flags.get(flag.flag), STEP)
            yield from item(_flag_row(flag), STEP)


def _named(key: str, rows: Mapping[str, Any], comments: Mapping[str, str]) -> Iterator[str]:
    """Yield a mapping of names, one line each."""
    if rows:
        yield f'{key}:'
    for name, row in rows.items():
        yield from _comment(comments.get(name), STEP)
        yield from entry(name, row, STEP)


def _given(made_from: MadeFrom) -> Row:
    return {name: value for name, value in vars(made_from).items() if value not in ('', ())}


def _parameter_row(parameter: Parameter) -> Row:
    default = {} if parameter.required else {'default': parameter.default}
    return {'type': parameter.type, **default}


def _flag_row(flag: Dependency) -> Row:
    row: Row = {'flag': flag.flag, 'upstream': flag.upstream, 'downstream': flag.downstream}
    if flag.capacity != 1:
        row['capacity'] = flag.capacity
    if flag.initial:
        row['initial'] = flag.initial
    return row


def _comment(text: str | None, indent: str) -> Iterator[str]:
    """Yield the lines of a comment; none, if there is nothing to say."""
    lines: Iterable[str] = text.splitlines() if text else ()
    for line in lines:
        printable = ''.join(char if char.isprintable() else ' ' for char in line)
        for part in textwrap.wrap(printable, COMMENT_WIDTH - len(indent)) or ('',):
            yield f'{indent}# {part}'.rstrip()


# Tasks and conditions as the mappings that a script has for them; defaults are left out.

Row = dict[str, Any]


def task_row(task: Task, cell: Cell | None, default_id: str) -> Row:
    """Return a task as a script says it, its keys in the order of the reference.

    :param default_id: the id that it has where it stands, if none is written
    """
    own = _own_keys(task, cell, default_id)
    values = ((key.name, own[key.name] if key.name in own else _set(key, task)) for key in _KEYS)
    return {name: value for name, value in values if value is not None}


_KEYS = (*TASK.keys, INITIALIZATION_TASK.by_name['once'])


def _set(key: Key, task: Task) -> Any:
    """Return what a key sets; None: what holds when it is absent."""
    value = getattr(task, key.sets) if key.sets else key.default
    plain = value.value if isinstance(value, Enum) else value
    return None if plain == key.default else plain


def _own_keys(task: Task, cell: Cell | None, default_id: str) -> Mapping[str, Any]:
    """Return the keys that say more than one field; None: not written."""
    condition, limit = task.condition, task.timeout_s
    is_usual = cell is not None and limit == cell.components[task.component].timeout_s
    when = (
        {}
        if condition is None
        else {'unless' if condition.negated else 'when': condition_row(condition)}
    )
    return {
        'id': task.id if task.id != default_id else None,
        'task': task.name,
        'action': task.action,
        'args': task.args or None,
        'on_failure': task.on_failure.value if task.on_failure is not OnFailure.HOLD else None,
        'timeout': None if is_usual else 'none' if limit is None else limit,
        **when,
        'fails_unless': task.fails_unless and condition_row(task.fails_unless),
        'identifies': '.'.join(task.identifies) or None,
        'setup': task.setup or None,
    }


def condition_row(condition: Condition) -> Any:
    """Return a condition as a script says it; a boolean needs no comparison."""
    if condition.parts:
        key = 'all' if condition.all else 'any'
        return {key: [condition_row(part) for part in condition.parts]}
    compared = dict(_comparison(condition))
    return {'value': condition.value, **compared} if compared else condition.value


def _comparison(condition: Condition) -> Iterator[tuple[str, Any]]:
    low, high = condition.at_least, condition.at_most
    if condition.one_of:
        yield 'one_of', condition.one_of
    elif condition.not_equals is not None:
        yield 'not_equals', condition.not_equals
    elif low is not None and high is not None:
        yield 'between', [low, high]
    elif low is not None:
        yield 'at_least', low
    elif high is not None:
        yield 'at_most', high
    elif condition.equals is not True:
        yield 'equals', condition.equals
