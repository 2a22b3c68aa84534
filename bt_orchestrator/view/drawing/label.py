"""Text in boxes: tables of lines of text, as data that every canvas can draw."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from dataclasses import dataclass

FONT = 'Helvetica,Arial,sans-serif'
"""The family of all text."""

INK = '#1f2933'
FAINT = '#5f6b7a'
RULE = '#b8c0cc'
PAPER = '#ffffff'
BAR_FILL = '#47525f'
SECTION_FILL = '#f4f6f9'
SLOT_FILL = '#d5dae2'
GROUP_FILL = '#e6ebf2'
FLAG = '#b45309'
BELT = '#8a94a3'
LOOP_LINE = '#4f46e5'
ALARM = '#b00020'
"""Frames of what failed or is held."""


CARD_COLUMNS = 34
"""Letters in a line of a card: longer ones are broken, to keep columns narrow."""

_INDENT = '  '
_SIGNS = '_/.-'
"""Between the words of an id, a topic, a reference."""

LINE_HEIGHT = 1.2
"""Height of a line as a multiple of its font size."""

ENTRY_PADDING = 2.0
"""Points between the edge of an entry and its text."""


@dataclass(frozen=True)
class Text:
    """One line of text in one font."""

    text: str
    size: int = 10
    colour: str = INK
    bold: bool = False
    italic: bool = False

    @property
    def height(self) -> float:
        """Points from this line to the next one."""
        return self.size * LINE_HEIGHT


@dataclass(frozen=True)
class Entry:
    """One field of a table: lines below each other."""

    texts: tuple[Text, ...]
    centred: bool = False
    fill: str = ''
    span: int = 1
    width: float = 0.0
    height: float = 0.0
    """Least sizes, in points."""

    @property
    def content_height(self) -> float:
        """Points that its lines need."""
        return sum(text.height for text in self.texts) + 2 * ENTRY_PADDING


@dataclass(frozen=True)
class Label:
    """A table of entries."""

    rows: tuple[tuple[Entry, ...], ...]
    border: int = 0
    """Width of its frame; 0: none."""
    fill: str = ''
    dashed: bool = False
    height: float = 0.0
    """The least one."""


def one_entry(*texts: Text, width: float = 0.0) -> Label:
    """Return a label without a frame around some lines."""
    return Label(((Entry(texts, width=width),),))


def wrapped(text: str, columns: int = CARD_COLUMNS) -> list[str]:
    """Break a text into lines, also inside words that are too long (ids, topics, references)."""
    lines = textwrap.wrap(text, columns, subsequent_indent=_INDENT, break_long_words=False)
    return [part for line in lines for part in _broken(line, columns)] or ['']


def _broken(line: str, columns: int) -> Iterator[str]:
    """Yield a line that is one long word in parts, if possible behind a sign."""
    while len(line) > columns:
        end = max(line.rfind(sign, 0, columns) for sign in _SIGNS) + 1
        end = end if end * 3 > columns else columns
        yield line[:end]
        line = _INDENT + line[end:]
    yield line
