"""Drawings of lines, read back from their SVG."""

from __future__ import annotations

import re
from typing import NamedTuple
from xml.etree import ElementTree as ET

SVG = '{http://www.w3.org/2000/svg}'


class Area(NamedTuple):
    """A rectangle, y downwards."""

    left: float
    top: float
    right: float
    bottom: float

    def holds(self, other: Area) -> bool:
        return (
            self.left <= other.left
            and self.right >= other.right
            and self.top <= other.top
            and self.bottom >= other.bottom
        )

    def meets(self, other: Area) -> bool:
        return (
            self.left < other.right
            and other.left < self.right
            and self.top < other.bottom
            and other.top < self.bottom
        )


class DrawnLine:
    """The parts of a drawing, by name."""

    def __init__(self, svg: str) -> None:
        self.root = ET.fromstring(svg)
        self.layers = self.root.findall(f'{SVG}g')
        self.parts = {
            part.get('id', ''): part for layer in self.layers for part in layer.findall(f'{SVG}g')
        }

    def words(self, part: str) -> list[str]:
        """Return the text on a part, line by line."""
        return [(text.text or '').strip(' \xa0') for text in self.parts[part].iter(f'{SVG}text')]

    def about(self, part: str) -> str:
        """Return the tooltip of a part."""
        return self.parts[part].findtext(f'{SVG}title') or ''

    def look(self, part: str) -> ET.Element:
        """Return the outer rectangle of a card or frame, or the path of a line."""
        shapes = (child for child in self.parts[part] if child.tag in (f'{SVG}rect', f'{SVG}path'))
        return next(shapes)

    def area(self, part: str) -> Area:
        """Return the place of a frame or card, with its border."""
        rect = self.look(part)
        x, y, width, height = (float(rect.get(n, '')) for n in ('x', 'y', 'width', 'height'))
        edge = float(rect.get('stroke-width', 0)) / 2 if part.startswith('task.') else 0.0
        return Area(x - edge, y - edge, x + width + edge, y + height + edge)

    def card(self, task: str) -> Area:
        """Return the place of a task's card."""
        return self.area(f'task.{task}')

    def points(self, line: str) -> list[tuple[float, float]]:
        """Return the first point of a line, its bends and the tip of its arrow."""
        path, *head = (child for child in self.parts[line] if child.tag == f'{SVG}path')
        points = _points(path.get('d', ''))
        return [*points, _points(head[0].get('d', ''))[0]] if head else points


def _points(way: str) -> list[tuple[float, float]]:
    return [(float(x), float(y)) for x, y in re.findall(r'(-?[\d.]+),(-?[\d.]+)', way)]
