"""Text in drawings: Graphviz' HTML-like labels, wrapped lines, and colours on white paper."""

from __future__ import annotations

import html
import textwrap
from collections.abc import Iterable, Sequence

FONT = 'Helvetica,Arial,sans-serif'
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

CARD_COLUMNS = 34
"""Letters in a line of a card: longer ones are broken, so that columns stay narrow."""


def escaped(text: str) -> str:
    """Return plain text for an HTML-like label."""
    return html.escape(text, quote=False)


def tooltip(lines: Iterable[str]) -> str:
    """Return lines for a tooltip, which is no HTML but knows backslashes."""
    return '\n'.join(line.replace('\\', '\\\\') for line in lines)


def wrapped(text: str, columns: int = CARD_COLUMNS) -> list[str]:
    """Break a text into lines, also inside words that are too long (topics, references)."""
    return textwrap.wrap(text, columns, subsequent_indent='  ') or ['']


def font(
    text: str, *, size: int = 10, colour: str = INK, bold: bool = False, italic: bool = False
) -> str:
    """Return escaped text in a font."""
    inner = escaped(text)
    inner = f'<I>{inner}</I>' if italic else inner
    inner = f'<B>{inner}</B>' if bold else inner
    return f'<FONT POINT-SIZE="{size}" COLOR="{colour}">{inner}</FONT>'


def lines(texts: Sequence[str]) -> str:
    """Put marked-up lines below each other, all to the left."""
    return ''.join(f'{text}<BR ALIGN="LEFT"/>' for text in texts)


def entry(
    content: str,
    *,
    align: str = 'LEFT',
    fill: str = '',
    span: int = 1,
    width: float = 0,
    height: float = 0,
) -> str:
    """Return one cell of a table; content is marked up already, sizes are the least ones."""
    attributes = [f'ALIGN="{align}"', f'BALIGN="{align}"', 'CELLPADDING="2"']
    attributes += [f'BGCOLOR="{fill}"'] if fill else []
    attributes += [f'COLSPAN="{span}"'] if span > 1 else []
    attributes += [f'WIDTH="{width:g}"'] if width else []
    attributes += [f'HEIGHT="{height:g}"'] if height else []
    return f'<TD {" ".join(attributes)}>{content}</TD>'


def table(
    rows: Iterable[Sequence[str]],
    *,
    border: int = 0,
    fill: str = '',
    dashed: bool = False,
    height: float = 0,
) -> str:
    """Return a whole label: a table of rows of entries; height is the least one."""
    attributes = [f'BORDER="{border}"', 'CELLBORDER="0"', 'CELLSPACING="0"']
    attributes += [f'COLOR="{INK}"'] if border else []
    attributes += [f'BGCOLOR="{fill}"'] if fill else []
    attributes += ['STYLE="dashed"'] if dashed else []
    attributes += [f'HEIGHT="{height:g}"'] if height else []
    body = ''.join(f'<TR>{"".join(entries)}</TR>' for entries in rows)
    return f'<<TABLE {" ".join(attributes)}>{body}</TABLE>>'
