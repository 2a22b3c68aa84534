"""Arguments of a request as one text, JSON or YAML."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from bt_orchestrator.base.errors import CommandRefused
from bt_orchestrator.model.limits import REQUEST_BYTES, RESULTS_TEXT
from bt_orchestrator.script.composing import compose
from bt_orchestrator.script.report import Report
from bt_orchestrator.script.yaml_nodes import as_data

_EXPECTED = 'expected the arguments as a mapping in JSON or YAML, as in {"job": "WO-7"}'


def arguments_of(text: str) -> Mapping[str, Any]:
    """Return arguments by name; an empty text has none.

    :raises CommandRefused: says what was expected and what was found
    """
    if len(text) > REQUEST_BYTES:
        raise CommandRefused(
            f'the arguments have {len(text)} characters; expected at most {REQUEST_BYTES}; '
            'give fewer at a time'
        )
    plain = _plain(text) if text.strip() else {}
    if not isinstance(plain, Mapping) or not all(isinstance(name, str) for name in plain):
        raise CommandRefused(f'{_EXPECTED}; found {json.dumps(plain):.60}')
    return plain


def _plain(text: str) -> object:
    try:
        plain = json.loads(text)
        json.dumps(plain, ensure_ascii=False).encode()  # half a character would end the process
    except UnicodeEncodeError as error:
        raise CommandRefused(f'the arguments are not a valid text: {error.reason}') from error
    except (ValueError, RecursionError):
        return _yaml(text)
    return plain


def _yaml(text: str) -> object:
    if len(text) > RESULTS_TEXT:
        raise CommandRefused(f'arguments of more than {RESULTS_TEXT} characters must be JSON')
    report = Report('arguments')
    node = compose(text, report)
    if report.findings or node is None:
        told = '. '.join(f'{one.what}; {one.hint}' for one in report.findings[:3])
        raise CommandRefused(f'{_EXPECTED}; {told or "found nothing"}')
    return as_data(node)
