"""The writer of all SVG: elements with attributes in a fixed order, and short numbers."""

from __future__ import annotations

import re
from typing import Any
from xml.etree import ElementTree as ET

from bt_orchestrator.view.drawing.canvas import Box
from bt_orchestrator.view.drawing.label import FONT, INK, PAPER

CHARACTER = 0.62
"""Width of a character as a part of the font size, at most."""


class Svg:
    """An element that others are put into."""

    def __init__(self, element: ET.Element) -> None:
        self._element = element

    @classmethod
    def page(cls, area: Box, title: str, unit: str = '') -> Svg:
        """Begin a picture on white paper.

        :param title: what it shows; screen readers say it
        :param unit: of the numbers in it; empty: pixels
        """
        width, height = _text(area.width), _text(area.height)
        size = {'width': f'{width}{unit}', 'height': f'{height}{unit}'}
        view = ' '.join(map(_text, (area.left, area.top, area.width, area.height)))
        root = {'xmlns': 'http://www.w3.org/2000/svg', **size, 'viewBox': view, 'role': 'img'}
        page = cls(ET.Element('svg', {**root, 'font-family': FONT, 'fill': INK}))
        page.add('title', title)
        page.add('rect', x=area.left, y=area.top, width=width, height=height, fill=PAPER)
        return page

    @classmethod
    def part(cls, width: float, height: float, **attributes: Any) -> Svg:
        """Begin a drawing in a page of HTML, whose style it has; it is as wide as its place."""
        drawing = cls(ET.Element('svg'))
        drawing._set(
            viewBox=f'0 0 {_text(width)} {_text(height)}',
            preserveAspectRatio='none',
            aria_hidden='true',
            **attributes,
        )
        return drawing

    def add(self, name: str, text: str = '', **attributes: Any) -> Svg:
        """Add an element.

        In attribute names an underscore becomes a hyphen (`font_size`); a trailing one is dropped
        (`class_`).
        """
        child = Svg(ET.SubElement(self._element, name))
        child._set(**attributes)
        child._element.text = xml_text(text) or None
        return child

    def _set(self, **attributes: Any) -> None:
        for key, value in attributes.items():
            name = key.rstrip('_').replace('_', '-')
            self._element.set(name, xml_text(_text(value)))

    def __str__(self) -> str:
        ET.indent(self._element)
        head = '<?xml version="1.0" encoding="UTF-8"?>\n'
        return head + ET.tostring(self._element, encoding='unicode') + '\n'


def _text(value: Any) -> str:
    return f'{value:.2f}'.rstrip('0').rstrip('.') if isinstance(value, float) else str(value)


def xml_text(text: str) -> str:
    """Return a text without characters that XML 1.0 cannot carry."""
    return _NOT_XML.sub('\N{REPLACEMENT CHARACTER}', text)


_NOT_XML = re.compile('[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]')
"""Characters outside production 2 of XML 1.0."""
