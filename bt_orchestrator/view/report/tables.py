"""Text for a person: aligned tables, and values of records."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from typing import Any

from bt_orchestrator.model.codec import from_plain


def table(headers: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """Yield the lines of a table: the first column to the left, numbers to the right."""
    lines = [headers, *rows]
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    for first, *others in lines:
        cells = [text.rjust(width) for text, width in zip(others, widths[1:], strict=True)]
        yield '  '.join([first.ljust(widths[0]), *cells]).rstrip()


def shown(plain: Any) -> str:
    """Return a value of a record for a person: `nan` as such, nothing that a terminal obeys."""
    value = from_plain(Any, plain)
    if isinstance(value, str) and value and ' ' not in value and value.isprintable():
        return value
    text = json.dumps(value, ensure_ascii=False)
    return text if text.isprintable() else json.dumps(value).replace('\x7f', '\\u007f')
