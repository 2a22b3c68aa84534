"""The status of a cell as JSON: every object in it, and what its fields hold."""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Iterator, Mapping
from typing import Any, get_args, get_origin

from bt_orchestrator.model.codec import hints_of
from bt_orchestrator.model.status import CellStatus
from bt_orchestrator.model.wait import StandCause, WaitKind
from tables import docstrings
from tables.markdown import cell, table

SCALARS: Mapping[Any, str] = {
    str: 'text',
    int: 'whole number',
    float: 'number',
    bool: 'true or false',
}


def status() -> Iterator[str]:
    """Yield a table for each kind of object in a status, the whole one first."""
    for kind in _kinds(CellStatus):
        yield f'**{_named(kind)}.** {cell(inspect.cleandoc(kind.__doc__ or ""))}'
        yield ''
        documented = docstrings.of_fields(kind)
        rows = (
            (f'`{name}`', _holds(hint), cell(documented.get(name, '')).replace('None', '`null`'))
            for name, hint in hints_of(kind).items()
        )
        yield from table(('field', 'holds', 'meaning'), rows)


def kinds_of_waits() -> Iterator[str]:
    """Yield a table of what is waited for."""
    documented = docstrings.of_members(WaitKind)
    yield from table(
        ('kind', 'waits for'),
        ((f'`{kind.value}`', cell(documented[kind.value])) for kind in WaitKind),
    )


def causes_of_a_standstill() -> Iterator[str]:
    """Yield a table of the causes for which a cell stands."""
    documented = docstrings.of_members(StandCause)
    rows = ((f'`{cause.value}`', cell(documented[cause.value])) for cause in StandCause)
    yield from table(('cause', 'meaning'), rows)


def _kinds(kind: Any) -> list[type]:
    """Return a class of objects and those of the objects in it, each once."""
    found = [kind]
    for one in found:
        inner = (_member(hint) for hint in hints_of(one).values())
        found += [
            c for c in dict.fromkeys(inner) if dataclasses.is_dataclass(c) and c not in found
        ]
    return found


def _member(hint: Any) -> Any:
    """Return what a field holds: one, or several."""
    arguments = [one for one in get_args(hint) if one not in (type(None), Ellipsis)]
    return arguments[-1] if arguments else hint


def _holds(hint: Any) -> str:
    member, origin = _member(hint), get_origin(hint)
    word = SCALARS.get(member) or (_named(member) if dataclasses.is_dataclass(member) else 'text')
    if origin is tuple:
        return f'list of {word}'
    if origin is Mapping:
        return f'{word} by name'
    is_optional = type(None) in get_args(hint)
    return f'{word} or `null`' if is_optional else word


def _named(kind: Any) -> str:
    """Return the name of a class of objects as words."""
    words = ''.join(f' {c.lower()}' if c.isupper() else c for c in kind.__name__).strip()
    return 'status' if kind is CellStatus else words.removesuffix(' status')
