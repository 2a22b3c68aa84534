"""Tables of Markdown."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence


def table(titles: Sequence[str], rows: Iterable[Iterable[str]]) -> Iterator[str]:
    """Yield a table and an empty line."""
    yield _row(titles)
    yield f'|{"---|" * len(titles)}'
    yield from map(_row, rows)
    yield ''


def cell(text: str) -> str:
    """Return a text for one cell of a table."""
    return ' '.join(text.split()).replace('|', r'\|')


def code(text: str) -> str:
    """Return a text as code for one cell of a table."""
    return f'`` {cell(text)} ``' if '`' in text else f'`{cell(text)}`'


def _row(words: Iterable[str]) -> str:
    return f'| {" | ".join(words)} |'
