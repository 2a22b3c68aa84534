"""A small writer of SVG: elements with attributes, in a fixed order, with numbers kept short."""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree as ET

CHARACTER = 0.62
"""Width of a character as a part of the font size, at most."""


class Svg:
    """An element that others are put into."""

    def __init__(self, element: ET.Element) -> None:
        self._element = element

    @classmethod
    def page(cls, width: float, height: float) -> Svg:
        """Begin a drawing."""
        size = {'width': _text(width), 'height': _text(height)}
        view = f'0 0 {_text(width)} {_text(height)}'
        root = {'xmlns': 'http://www.w3.org/2000/svg', **size, 'viewBox': view}
        return cls(ET.Element('svg', root))

    def add(self, name: str, text: str = '', **attributes: Any) -> Svg:
        """Add an element; `_` in an attribute's name stands for a hyphen, at its end for none."""
        named = {
            key.rstrip('_').replace('_', '-'): _text(value) for key, value in attributes.items()
        }
        child = ET.SubElement(self._element, name, named)
        child.text = text or None
        return Svg(child)

    def label(self, x: float, y: float, text: str, kind: str, room: float | None = None) -> bool:
        """Write a text, unless it does not fit into the room; tells whether it did."""
        if room is not None and fitting(text, kind, room) != text:
            return False
        if text:
            self.add('text', text, x=x, y=y, class_=kind)
        return True

    def __str__(self) -> str:
        ET.indent(self._element)
        head = '<?xml version="1.0" encoding="UTF-8"?>\n'
        return head + ET.tostring(self._element, encoding='unicode') + '\n'


FONT = {'title': 16.0, 'row': 12.0, 'item': 10.0, 'task': 9.0, 'tick': 10.0, 'legend': 11.0}
"""Sizes of texts, in pixels, by the class of the text."""


def fitting(text: str, kind: str, room: float) -> str:
    """Return a text, or as much of it as fits into the room; nothing where that says nothing."""
    most = int(room / (FONT[kind] * CHARACTER))
    if len(text) <= most:
        return text
    return f'{text[: most - 1]}…' if most >= 3 else ''


def _text(value: Any) -> str:
    return f'{value:.2f}'.rstrip('0').rstrip('.') if isinstance(value, float) else str(value)
