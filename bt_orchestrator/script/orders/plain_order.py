"""A work order as one JSON object: read as a file is, and each mistake told with its key."""

from __future__ import annotations

import json
from bisect import bisect
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from bt_orchestrator.base.errors import Finding, Refused
from bt_orchestrator.model.action_type import ActionType
from bt_orchestrator.model.cell import MOST_ITEMS
from bt_orchestrator.model.jobs.order import Job, WorkOrder
from bt_orchestrator.model.script import Script
from bt_orchestrator.ports import WrongField
from bt_orchestrator.script.orders.order_file import (
    bind_order,
    params_from_text,
    parse_draft,
    parse_order,
)
from bt_orchestrator.script.report import Place
from bt_orchestrator.script.script_keys import ORDER

Plain = Mapping[str, object]
"""An order with the keys of an order file; times are texts with their zone."""


def order_from(plain: Plain) -> WorkOrder:
    """Read an order.

    :raises Refused: with every mistake in it
    """
    return parse_order(_text(plain), _name(plain)).order


def draft_of(plain: Plain) -> tuple[WorkOrder | None, tuple[WrongField, ...]]:
    """Return an order, and its mistakes that no script changes.

    The order is None if it cannot be known which script or recipe it names.
    """
    fields = list(_fields(plain))
    try:
        draft = parse_draft(_text(plain), _name(plain))
    except Refused as refused:
        return None, _by_field(refused.findings, fields)
    is_sure = all(map(draft.places.is_sure, ('script', 'recipe')))
    return draft.order if is_sure else None, _by_field(draft.places.findings, fields)


def bound(
    plain: Plain,
    script: Script,
    types: Mapping[str, ActionType],
    most_items: int = MOST_ITEMS,
) -> Job | tuple[WrongField, ...]:
    """Make a job of an order, or return every mistake in it.

    Parameters may be texts written as in YAML, as clients of a node send them.
    """
    fields = [*_fields(plain), *_left_open(plain, script)]
    try:
        draft = parse_draft(_text(plain), _name(plain))
        given = draft.order.params
        texts = {name: value for name, value in given.items() if isinstance(value, str)}
        order = replace(draft.order, params={**given, **params_from_text(texts, script)})
        known = {tuple(field.path.split('.')): Place(field.line, 1) for field in fields}
        places = replace(draft.places, places={**known, **draft.places.places})
        return bind_order(order, script, order.order or script.name, places, types, most_items)
    except Refused as refused:
        return _by_field(refused.findings, fields)


class _Field(NamedTuple):
    line: int
    """In the text, where it begins."""
    path: str


def _text(plain: object) -> str:
    """Return YAML that says the same, each key in lines of its own."""
    return json.dumps(plain, indent=1, ensure_ascii=False)


def _name(plain: Plain) -> str:
    return f'order {plain.get("order") or plain.get("script") or ""}'.strip()


def _fields(plain: Plain, line: int = 1, around: str = '') -> Iterator[_Field]:
    """Yield where in the text each key begins."""
    yield _Field(line, around)
    for key, value in plain.items():
        line += 1
        if key == 'params' and isinstance(value, Mapping):
            yield from _fields(value, line, key)
        else:
            yield _Field(line, f'{around}.{key}' if around else key)
        line += _text(value).count('\n') if isinstance(value, Mapping | list) else 0


def _left_open(plain: Plain, script: Script) -> Iterator[_Field]:
    """Yield places below the text for what an order does not say."""
    params = plain.get('params')
    given = params if isinstance(params, Mapping) else {}
    paths = [key for key in ORDER.by_name if key not in plain]
    paths += [f'params.{name}' for name in script.params if name not in given]
    end = _text(plain).count('\n') + 2
    yield from (_Field(end + number, path) for number, path in enumerate(paths))


def _by_field(findings: Sequence[Finding], fields: Sequence[_Field]) -> tuple[WrongField, ...]:
    """Name the key of each mistake: the last one that begins in its line, or above."""
    lines = [field.line for field in fields]
    return tuple(
        WrongField(fields[bisect(lines, finding.line) - 1].path, finding.what, finding.hint)
        for finding in findings
    )
