"""Labels and tooltips as Graphviz reads them: HTML-like tables, and text with backslashes."""

from __future__ import annotations

import html
from collections.abc import Iterable

from bt_orchestrator.drawing.label import Entry, Label, Text
from bt_orchestrator.drawing.style import INK
from bt_orchestrator.report.xml_text import xml_text


def dot_label(label: Label) -> str:
    """Return a label as an HTML-like table."""
    attributes = [f'BORDER="{label.border}"', 'CELLBORDER="0"', 'CELLSPACING="0"']
    attributes += [f'COLOR="{INK}"'] if label.border else []
    attributes += [f'BGCOLOR="{label.fill}"'] if label.fill else []
    attributes += ['STYLE="dashed"'] if label.dashed else []
    attributes += [f'HEIGHT="{label.height:g}"'] if label.height else []
    body = ''.join(f'<TR>{"".join(map(_entry, row))}</TR>' for row in label.rows)
    return f'<<TABLE {" ".join(attributes)}>{body}</TABLE>>'


def tooltip(lines: Iterable[str]) -> str:
    """Return lines for a tooltip, which is no HTML but knows backslashes."""
    return xml_text('\n'.join(line.replace('\\', '\\\\') for line in lines))


def _entry(entry: Entry) -> str:
    align = 'CENTER' if entry.centred else 'LEFT'
    attributes = [f'ALIGN="{align}"', f'BALIGN="{align}"', 'CELLPADDING="2"']
    attributes += [f'BGCOLOR="{entry.fill}"'] if entry.fill else []
    attributes += [f'COLSPAN="{entry.span}"'] if entry.span > 1 else []
    attributes += [f'WIDTH="{entry.width:g}"'] if entry.width else []
    attributes += [f'HEIGHT="{entry.height:g}"'] if entry.height else []
    content = f'<BR ALIGN="{align}"/>'.join(map(_text, entry.texts))
    if len(entry.texts) > 1:
        content += f'<BR ALIGN="{align}"/>'
    return f'<TD {" ".join(attributes)}>{content}</TD>'


def _text(text: Text) -> str:
    inner = html.escape(xml_text(text.text), quote=False)
    inner = f'<I>{inner}</I>' if text.italic else inner
    inner = f'<B>{inner}</B>' if text.bold else inner
    return f'<FONT POINT-SIZE="{text.size}" COLOR="{text.colour}">{inner}</FONT>'
