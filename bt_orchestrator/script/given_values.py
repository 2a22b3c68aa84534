"""Values that a person gives as text: arguments of a request, results of a task."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.model.action_type import TASK_RESULT, ActionType, MessageType
from bt_orchestrator.model.limits import REQUEST_BYTES, RESULTS_TEXT
from bt_orchestrator.model.words import sentence
from bt_orchestrator.script.checks.arguments import MessageReader
from bt_orchestrator.script.composing import compose
from bt_orchestrator.script.report import Report
from bt_orchestrator.script.task_values import settable
from bt_orchestrator.script.yaml_nodes import MapNode, as_data, found, plain_value

_EXAMPLE = '{"job": "WO-7"}'


def arguments_of(text: str) -> Mapping[str, Any]:
    """Return arguments by name; an empty text has none.

    :raises CommandRefused: says what was expected and what was found
    """
    if len(text) > REQUEST_BYTES:
        raise CommandRefused(sentence('fewer_arguments', count=len(text), most=REQUEST_BYTES))
    plain = _plain(text) if text.strip() else {}
    if not isinstance(plain, Mapping) or not all(isinstance(name, str) for name in plain):
        raise CommandRefused(_no_arguments(f'{json.dumps(plain):.60}'))
    return plain


def _no_arguments(found_words: str) -> str:
    return sentence('no_arguments', example=_EXAMPLE, found=found_words)


def _plain(text: str) -> object:
    try:
        plain = json.loads(text)
        json.dumps(plain, ensure_ascii=False).encode()  # half a character would end the process
    except UnicodeEncodeError as error:
        raise CommandRefused(sentence('no_text', cause=error.reason)) from error
    except (ValueError, RecursionError):
        return _yaml(text)
    return plain


def _yaml(text: str) -> object:
    if len(text) > RESULTS_TEXT:
        raise CommandRefused(sentence('long_yaml', most=RESULTS_TEXT))
    report = Report('arguments')
    node = compose(text, report)
    if report.findings:
        problems = '. '.join(f'{finding.what}; {finding.hint}' for finding in report.findings[:3])
        raise CommandRefused(sentence('wrong_arguments', example=_EXAMPLE, words=problems))
    if node is None:
        raise CommandRefused(_no_arguments('nothing'))
    return as_data(node)


# Results of a task that an operator gives with `mark_done`, against its action's type (6.3).

_TOLD = 5
"""The number of mistakes that are named."""


def given_results(text: str, action: ActionType) -> dict[str, Any]:
    """Read `{measurement: 3.5, item_present: true}` as result fields of an action.

    :raises CommandRefused: says what was expected, and what was found
    """
    fields = {name: field for name, field in action.result.fields.items() if name != TASK_RESULT}
    return _values(text, MessageType(action.result.name, fields), 'results')


def given_goal(text: str, action: ActionType) -> dict[str, Any]:
    """Read `{speed: 0.5}` as fields of a goal of an action (semantics 7.11).

    :raises CommandRefused: says what was expected, and what was found
    """
    return _values(text, settable(action), 'args')


def _values(text: str, fields: MessageType, what: str) -> dict[str, Any]:
    if len(text) > RESULTS_TEXT:
        words = sentence('long_fields', fields=what, count=len(text), most=RESULTS_TEXT)
        raise CommandRefused(words)
    report = Report(what)
    node = compose(text, report)
    values: dict[str, Any] = {}
    if isinstance(node, MapNode):
        values = MessageReader(report).read(node, fields)
    elif node is not None:
        expected = {'fields': what, 'example': '{field: value, ...}'}
        raise CommandRefused(sentence('no_fields', **expected, found=found(node)))
    if report.findings:
        problems = [f'{finding.what}; {finding.hint}' for finding in report.findings[:_TOLD]]
        raise CommandRefused(sentence(f'wrong_{what}', words='. '.join(problems)))
    return values


def results_of(words: Sequence[str]) -> dict[str, Any]:
    """Return what is said by `measurement=3.5`, `pose.x=1`, ... one field a word.

    :raises ValueError: says what was expected
    """
    fields: dict[str, Any] = {}
    for word in words:
        name, equals, value = word.partition('=')
        *around, last = name.strip().split('.')
        if not equals or not all((*around, last)):
            raise ValueError(f'a result is FIELD=VALUE, found {word!r}')
        place = fields
        for part in around:
            place = place.setdefault(part, {})
            if not isinstance(place, dict):
                raise ValueError(f'{part} is given as a whole and in parts: {word!r}')
        if last in place:
            raise ValueError(f'{name} is given twice')
        place[last] = _value(value)
    return fields


def results_text(values: Mapping[str, Any]) -> str:
    """Return results as `given_results` reads them; nothing if there are none."""
    return json.dumps(values, ensure_ascii=False) if values else ''


def _value(text: str) -> Any:
    """Return what YAML makes of a value; the first sign tells lists, mappings and quotes."""
    if not text.startswith(('[', '{', '"', "'")):
        return plain_value(text)
    report = Report('value')
    node = compose(text, report)
    return text if node is None or report.findings else as_data(node)
