"""The syntax of `${...}`, and what each source of values offers (formats: script)."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import NamedTuple, cast

from bt_orchestrator.model.action_type import FieldType
from bt_orchestrator.model.reference import Reference, Source, Template
from bt_orchestrator.script.field_types import PARAMETER_TYPES
from bt_orchestrator.script.report import did_you_mean, listing
from bt_orchestrator.script.yaml_nodes import Scalar, quoted

OPEN = '${'

SOURCES = ('params', 'order', 'item', 'results')

FIXED: Mapping[str, Mapping[str, FieldType]] = {
    'order': {'id': PARAMETER_TYPES['str'], 'quantity': PARAMETER_TYPES['int']},
    'item': {'number': PARAMETER_TYPES['int'], 'id': PARAMETER_TYPES['str']},
}
"""Sources whose names are always the same."""

_FORMS = '`${params.NAME}`, `${order.id}`, `${item.number}`, `${results.TASK.FIELD}`'
_PATH = re.compile(r'[\w-]+(?:\.[\w-]+)*')


class ReferenceFault(Exception):
    """A reference cannot be read."""

    def __init__(self, what: str, hint: str) -> None:
        self.what, self.hint = what, hint
        super().__init__(what)


class Path(NamedTuple):
    """A reference as written: its source and the dotted rest."""

    source: str
    rest: str

    def __str__(self) -> str:
        return f'${{{self.source}.{self.rest}}}'


def has_reference(node: Scalar) -> bool:
    """Tell whether a scalar is a string with references in it; there is no way to escape `${`."""
    return isinstance(node.value, str) and OPEN in node.text


def split(text: str) -> Iterator[str | Path | ReferenceFault]:
    """Yield the plain parts and the references of a string, in order.

    In place of a reference that cannot be read it yields what is wrong with it.
    """
    rest = text
    while OPEN in rest:
        before, _, after = rest.partition(OPEN)
        inside, closing, rest = after.partition('}')
        if not closing:
            yield ReferenceFault(f'`{OPEN}` has no closing `}}`', 'close the reference with `}`')
            return
        if before:
            yield before
        try:
            yield path(inside)
        except ReferenceFault as fault:
            yield fault
    if rest:
        yield rest


def path(inside: str) -> Path:
    """Return what stands between the braces.

    :raises ReferenceFault: it is no reference
    """
    if not _PATH.fullmatch(inside):
        what = f'{quoted(f"${{{inside}}}")} is not a reference'
        near = re.sub(r'\s', '', inside)
        is_near = near != inside and _PATH.fullmatch(near)
        raise ReferenceFault(
            what, f'write `${{{near}}}`, without spaces' if is_near else f'write one of {_FORMS}'
        )
    source, _, rest = inside.partition('.')
    if source not in SOURCES:
        hint = did_you_mean(source, SOURCES, f'the sources are {listing(SOURCES)}')
        raise ReferenceFault(f'{quoted(f"${{{inside}}}")} has an unknown source', hint)
    if not rest:
        raise ReferenceFault(f'`${{{source}}}` names no value', f'write one of {_FORMS}')
    return Path(source, rest)


def fixed_reference(written: Path) -> tuple[Reference, FieldType]:
    """Return a reference to the order or the item, and its type.

    :raises ReferenceFault: they have no such value
    """
    names = FIXED[written.source]
    if written.rest not in names:
        hint = did_you_mean(written.rest, names, f'the {written.source} has {listing(names)}')
        raise ReferenceFault(f'{quoted(str(written))} does not exist', hint)
    return Reference(cast(Source, written.source), written.rest), names[written.rest]


def is_single(template: Template) -> bool:
    """Tell whether a template is exactly one reference, which keeps the referenced type."""
    return len(template.parts) == 1
