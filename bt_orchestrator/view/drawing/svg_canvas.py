"""The canvas of a line, as SVG: no other program runs, and equal pictures are equal files."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from bt_orchestrator.view.drawing.canvas import (
    CORNER,
    HEADING,
    PADDING,
    Box,
    LineLabel,
    Point,
    Stroke,
    towards,
)
from bt_orchestrator.view.drawing.label import ENTRY_PADDING, INK, RULE, Entry, Label, Text
from bt_orchestrator.view.drawing.svg import Svg

BASELINE = 0.95
"""From the upper edge of a line to its baseline, as a part of the font size."""

INDENT = 6.0
"""Points from the left edge of a box to its text."""

ROUND = 12.0
"""Radius of the corners of a frame."""


class SvgCanvas:
    """One picture. Frames lie below lines, and lines below text.

    Names are unique in it, and are those of the parts in the file. `about` is shown, line by line,
    when a reader points at a part.
    """

    def __init__(self, size: Box, about: str) -> None:
        area = Box(
            size.left - PADDING,
            size.top - PADDING,
            size.width + 2 * PADDING,
            size.height + 2 * PADDING,
        )
        self._page = Svg.page(area, about, unit='pt')
        self._frames = self._page.add('g', id='frames', fill=INK)
        self._lines = self._page.add('g', id='lines', fill='none')
        self._labels = self._page.add('g', id='labels')

    def __str__(self) -> str:
        return str(self._page)

    def frame(self, name: str, heading: Label, box: Box, fill: str, about: Sequence[str]) -> None:
        """Draw a frame; parts that are drawn later lie on it."""
        part = _part(self._frames, name, about)
        _rect(part, box, fill=fill, stroke=RULE, rx=ROUND)
        width, height = heading.rows[0][0].width, _height(heading)
        _table(part, heading, Box(box.middle - width / 2, box.top + HEADING, width, height))

    def label(self, name: str, label: Label, box: Box, about: Sequence[str]) -> None:
        """Draw a table of text into a box."""
        part = _part(self._labels, name, about)
        if label.fill or label.border:
            _rect(part, _inside(box, label.border / 2), **_look(label))
        _table(part, label, _inside(box, label.border))

    def point(self, name: str, box: Box, about: Sequence[str]) -> None:
        """Draw a small dot where lines meet."""
        part = _part(self._labels, name, about)
        part.add('circle', cx=box.middle, cy=box.centre, r=2)

    def line(
        self,
        ends: tuple[str, str],
        points: Sequence[Point],
        stroke: Stroke,
        *,
        name: str = '',
        about: Sequence[str] = (),
        label: LineLabel | None = None,
    ) -> None:
        """Draw a line with round corners from one part to another."""
        part = _part(self._lines, name or f'{ends[0]}-{ends[1]}', about)
        length, half = max(7.0, 2.4 * stroke.width), max(2.5, 1.3 * stroke.width)
        tip, before = points[-1], points[-2]
        end = towards(tip, before, length) if stroke.head else tip
        look: dict[str, Any] = {'stroke': stroke.colour, 'stroke_width': stroke.width}
        look |= {'stroke_dasharray': _dashes(stroke.width)} if stroke.dashed else {}
        part.add('path', d=_way([*points[:-1], end]), **look)
        if stroke.head:
            part.add('path', d=_head(tip, end, half), fill=stroke.colour)
        if label is not None:
            ((entry,),) = label.label.rows
            _lines(part, entry, Box(*label.at, 0, 0), centred=True)


def _part(layer: Svg, name: str, about: Sequence[str]) -> Svg:
    part = layer.add('g', id=name)
    if about:
        part.add('title', '\n'.join(about))
    return part


def _rect(part: Svg, box: Box, **look: Any) -> None:
    part.add('rect', x=box.left, y=box.top, width=box.width, height=box.height, **look)


def _look(label: Label) -> dict[str, Any]:
    look: dict[str, Any] = {'fill': label.fill or 'none'}
    if label.border:
        look |= {'stroke': INK, 'stroke_width': label.border}
    return look | ({'stroke_dasharray': _dashes(label.border)} if label.dashed else {})


def _dashes(width: float) -> str:
    return f'{4 + 1.5 * width:g} {2 + width:g}'


def _inside(box: Box, edge: float) -> Box:
    return Box(box.left + edge, box.top + edge, box.width - 2 * edge, box.height - 2 * edge)


# --- tables -----------------------------------------------------------------------------------


def _height(label: Label) -> float:
    return sum(_row_height(row) for row in label.rows)


def _row_height(row: Sequence[Entry]) -> float:
    return max(max(entry.content_height, entry.height) for entry in row)


def _table(part: Svg, label: Label, box: Box) -> None:
    top = box.top
    for row in label.rows:
        height = min(_row_height(row), box.bottom - top)
        left = box.left
        for number, entry in enumerate(row, 1):
            width = box.right - left if number == len(row) else entry.width
            place = Box(left, top, width, height)
            if entry.fill:
                _rect(part, place, fill=entry.fill)
            _lines(part, entry, place, entry.centred)
            left += width
        top += height


def _lines(part: Svg, entry: Entry, box: Box, centred: bool) -> None:
    """Write the lines of an entry, as a whole in the middle of its height."""
    top = box.centre - entry.content_height / 2 + ENTRY_PADDING
    for text in entry.texts:
        at = {'x': box.middle, 'text_anchor': 'middle'} if centred else {'x': box.left + INDENT}
        if text.text.strip():
            part.add('text', _kept(text.text), **at, y=top + BASELINE * text.size, **_font(text))
        top += text.height


def _kept(text: str) -> str:
    """Return a text that keeps the blanks it begins with."""
    rest = text.lstrip(' ')
    return '\N{NO-BREAK SPACE}' * (len(text) - len(rest)) + rest


def _font(text: Text) -> dict[str, Any]:
    look: dict[str, Any] = {'font_size': text.size, 'fill': text.colour}
    look |= {'font_weight': 'bold'} if text.bold else {}
    return look | ({'font_style': 'italic'} if text.italic else {})


# --- lines ------------------------------------------------------------------------------------


def _way(points: Sequence[Point]) -> str:
    """Write a path with round corners."""
    parts = [f'M{_at(points[0])}']
    for before, corner, after in zip(points, points[1:], points[2:], strict=False):
        near, far = towards(corner, before, CORNER), towards(corner, after, CORNER)
        parts.append(f'L{_at(near)} Q{_at(corner)} {_at(far)}')
    return ' '.join([*parts, f'L{_at(points[-1])}'])


def _head(tip: Point, base: Point, half: float) -> str:
    """Write the triangle of an arrow."""
    x, y = tip[0] - base[0], tip[1] - base[1]
    length = (x * x + y * y) ** 0.5 or 1.0
    across = (-y / length * half, x / length * half)
    left = (base[0] + across[0], base[1] + across[1])
    right = (base[0] - across[0], base[1] - across[1])
    return f'M{_at(tip)} L{_at(left)} L{_at(right)} Z'


def _at(point: Point) -> str:
    return f'{point[0]:.1f},{point[1]:.1f}'
