"""Pieces of HTML: whatever a person or a device wrote is text in it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from html import escape
from typing import NamedTuple

from bt_orchestrator.report.xml_text import xml_text


def text(words: str) -> str:
    """Return words as text of a page."""
    return escape(xml_text(words))


class Column(NamedTuple):
    """A column of a table."""

    title: str
    kind: str = ''
    """n: a number, t: a time of the clock, bar: a bar; empty: text."""


class Row(NamedTuple):
    """A row of a table, as HTML."""

    cells: Sequence[str]
    kind: str = ''


def table(columns: Sequence[Column], rows: Iterable[Row]) -> Iterator[str]:
    """Yield the lines of a table."""
    yield '<div class="scroll"><table>'
    heads = ''.join(f'<th{_class(one.kind)}>{text(one.title)}</th>' for one in columns)
    yield f'<thead><tr>{heads}</tr></thead><tbody>'
    for row in rows:
        cells = ''.join(
            f'<td{_class(column.kind)}>{cell}</td>'
            for column, cell in zip(columns, row.cells, strict=True)
        )
        yield f'<tr{_class(row.kind)}>{cells}</tr>'
    yield '</tbody></table></div>'


def section(title: str, lines: Iterable[str], kind: str = '') -> Iterator[str]:
    """Yield a section with its heading; nothing if it would be empty."""
    found = list(lines)
    if found:
        yield f'<section{_class(kind)}><h2>{text(title)}</h2>'
        yield from found
        yield '</section>'


def _class(kind: str) -> str:
    return f' class="{kind}"' if kind else ''
