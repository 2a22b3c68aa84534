"""The events, and what their fields mean."""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Iterator, Mapping
from typing import Any, get_args, get_origin

from bt_orchestrator.model import events
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.codec import event_types, hints_of
from bt_orchestrator.model.jobs.order import MadeAnew, RecipeChoice
from bt_orchestrator.model.script import Script
from tables import docstrings
from tables.markdown import cell, table

FIELDS: Mapping[str, str] = {
    'action': 'ROS 2 action name',
    'answer': 'what was decided',
    'answers': 'what an operator may answer',
    'args': 'goal fields with plain values, references resolved',
    'attempt': 'which attempt, from 1',
    'beat': 'the beat that begins',
    'cell': 'name of the cell',
    'counts': 'the counts of the job, by name (semantics 6.2)',
    'component': 'name of the component in the cell file',
    'definition': 'the whole script, bound to the cell',
    'digest': 'name of the script by what it says: equal scripts have equal digests',
    'flag': 'name of the flag',
    'goal': 'goal UUID',
    'hold': 'id of the hold',
    'item': 'item id, `<job>/<n>`',
    'job': 'job id, the id of its work order',
    'message': 'the words of the server or the gateway, for a person',
    'params': 'all parameters, defaults filled in',
    'previous': 'the state before',
    'quantity': 'number of source cycles',
    'ready': 'whether a goal may be sent',
    'reason': 'why, one word or a sentence',
    'results': 'result fields of the task, `task_result` left out',
    'script': 'name of the script',
    'section': 'section number',
    'state': 'PackML state of the cell',
    'task': 'task id in the script; `index` for the move of the belt',
    'command': 'what was commanded',
    'who': 'who decided',
}
"""What a field means wherever the class says nothing of its own."""

KINDS: Mapping[Any, str] = {
    bool: 'true or false',
    int: 'whole number',
    float: 'number',
    Any: 'any value',
    tuple: 'list of text',
    Mapping: 'object',
    Script: 'object',
    Cell: 'object',
    RecipeChoice: 'object',
    MadeAnew: 'object',
    str: '',
}
"""What a field holds, by the origin of its annotation; nothing is said of text."""

PLACE = ('job', 'section', 'item', 'task')
"""Fields that most events have; explained once, above the tables."""


def events_in_groups() -> Iterator[str]:
    """Yield a table of every event class, by the part of its name before the dot."""
    groups: dict[str, list[type[events.Event]]] = {}
    for name, kind in event_types().items():
        groups.setdefault(name.partition('.')[0], []).append(kind)
    place = ((f'`{name}`{_kind(events.TaskStarted, name)}', cell(FIELDS[name])) for name in PLACE)
    yield from table(('where in the line', 'meaning'), place)
    for group, kinds in groups.items():
        yield f'## {group}'
        yield ''
        yield from table(('event', 'meaning', 'fields'), map(_event, kinds))


def _event(kind: type[events.Event]) -> tuple[str, str, str]:
    meaning = cell(inspect.cleandoc(kind.__doc__ or ''))
    return f'`{kind.event}`', meaning, '<br>'.join(_fields(kind))


def _fields(kind: type[events.Event]) -> list[str]:
    documented = _documented(kind)
    place, lines = [], []
    for field in dataclasses.fields(kind):
        if field.name in ('seq', 'time'):
            continue
        own = documented.get(field.name)
        absent = '?' if _has_default(field) else ''
        if own is None and field.name in PLACE:
            place.append(f'`{field.name}{absent}`')
        else:
            name = f'`{field.name}{absent}`{_kind(kind, field.name)}'
            lines.append(f'{name}: {cell(own or _common(kind, field.name))}')
    return [', '.join(place), *lines] if place else lines


def _kind(kind: type, field: str) -> str:
    """Return what a field holds, in brackets; nothing if it is text."""
    hint: Any = hints_of(kind)[field]
    if type(None) in get_args(hint):
        hint = get_args(hint)[0]
    words = KINDS[get_origin(hint) or hint]
    return f' ({words})' if words else ''


def _documented(kind: type[events.Event]) -> Mapping[str, str]:
    """Return what the class and its bases say of their fields, the class first."""
    found: dict[str, str] = {}
    for base in reversed(kind.__mro__[:-1]):
        found |= docstrings.of_fields(base)
    # A record leaves out what the class calls None.
    return {name: text.replace('None', 'absent') for name, text in found.items()}


def _common(kind: type[events.Event], field: str) -> str:
    """Return what a field means in any event.

    :raises SystemExit: nobody says it
    """
    if field not in FIELDS:
        what = f'{kind.__name__}.{field} has no meaning; write a docstring below the field'
        raise SystemExit(f'docs/generate.py: {what}, or a line in FIELDS')
    return FIELDS[field]


def _has_default(field: dataclasses.Field[Any]) -> bool:
    missing = dataclasses.MISSING
    return field.default is not missing or field.default_factory is not missing
