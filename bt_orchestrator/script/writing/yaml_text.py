"""Plain data as YAML that a person would write: what fits stands on one line."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from typing import Any

from bt_orchestrator.model.reference import Template
from bt_orchestrator.script.yaml_nodes import plain_value

WIDTH = 140
"""Columns of a line that holds a whole mapping or list."""

STEP = '  '

_PLAIN = re.compile(r'[^\W\d][\w.-]*|/[\w./-]*')
_OLD_SWITCHES = {'y', 'n', 'yes', 'no', 'on', 'off'}
"""Text here; older readers of YAML take them for true and false."""


def flow(value: Any) -> str:
    """Return a value on one line."""
    if isinstance(value, Mapping):
        return (
            f'{{{", ".join(f"{scalar(key)}: {flow(member)}" for key, member in value.items())}}}'
        )
    if is_list(value):
        return f'[{", ".join(map(flow, value))}]'
    return scalar(value)


def entry(key: str, value: Any, indent: str) -> Iterator[str]:
    """Yield the lines of a key with its value."""
    line = f'{indent}{scalar(key)}: {flow(value)}'
    if len(line) <= WIDTH or not _parts(value):
        yield line
    else:
        yield f'{indent}{scalar(key)}:'
        yield from _block(value, indent + STEP)


def item(value: Any, indent: str) -> Iterator[str]:
    """Yield the lines of a member of a list."""
    line = f'{indent}- {flow(value)}'
    if len(line) <= WIDTH or not _parts(value):
        yield line
    else:
        yield from dashed(_block(value, indent + STEP), indent)


def dashed(lines: Iterator[str], indent: str) -> Iterator[str]:
    """Yield the lines of something, which are indented by a step more, as a member of a list."""
    first = next(lines)
    return chain((f'{indent}- {first[len(indent) + len(STEP) :]}',), lines)


def is_list(value: Any) -> bool:
    """Tell whether a value is written as a list."""
    return isinstance(value, (list, tuple))


def _parts(value: Any) -> Sequence[Any] | Mapping[str, Any]:
    return value if isinstance(value, Mapping) or is_list(value) else ()


def _block(value: Any, indent: str) -> Iterator[str]:
    if isinstance(value, Mapping):
        for key, member in value.items():
            yield from entry(key, member, indent)
    else:
        for member in value:
            yield from item(member, indent)


# --- single values ---------------------------------------------------------------------------


def scalar(value: Any) -> str:
    """Return a single value in a form in which the reader finds the same, of the same type."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return _real(value)
    if isinstance(value, (str, Template)):
        return _text(str(value))
    return str(value)


def _real(value: float) -> str:
    """Write a number with a point, without which older readers take 1e-05 for text."""
    digits, exponent, power = repr(value).partition('e')
    return f'{digits}{"" if "." in digits else ".0"}{exponent}{power}'


def _text(text: str) -> str:
    is_plain = _PLAIN.fullmatch(text) and text.lower() not in _OLD_SWITCHES
    return text if is_plain and plain_value(text) == text else f'"{"".join(map(_escaped, text))}"'


def _escaped(char: str) -> str:
    if char in '"\\':
        return f'\\{char}'
    return char if char.isprintable() else f'\\U{ord(char):08x}'
