"""Lines of a terminal: cells side by side, cut with an ellipsis where they do not fit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from rich.cells import cell_len
from rich.text import Text

ELLIPSIS = '…'


class LinePart(NamedTuple):
    """A part of a line."""

    text: Text
    width: int | None
    """None: whatever the others leave."""


def line(cells: Sequence[LinePart], width: int) -> Text:
    """Return one line of a width: cells with a blank between them."""
    fixed = sum(cell.width for cell in cells if cell.width is not None) + len(cells) - 1
    joined = Text(no_wrap=True)
    for number, cell in enumerate(cells):
        own = max(width - fixed, 0) if cell.width is None else cell.width
        text = cell.text.copy()
        text.truncate(own, overflow='ellipsis', pad=True)
        joined.append(' ' if number else '').append_text(text)
    joined.truncate(width, overflow='ellipsis')
    return joined


def end_of(text: str, width: int) -> str:
    """Return a text, or as much of its end as fits: the number of an item says more than its job.

    >>> end_of('WO-2026-11-21/7', 8)
    '…1-21/7'
    """
    if cell_len(text) <= width:
        return text
    while text and cell_len(text) + 1 > width:
        text = text[1:]
    return f'{ELLIPSIS}{text}'


def widest(texts: Sequence[str], most: int) -> int:
    """Return the width that the widest of some texts takes, and no more than `most`."""
    return min(max(map(cell_len, texts), default=0), most)
