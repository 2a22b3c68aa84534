"""The writer of HTML: elements with escaped text, and the page around them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from importlib.metadata import PackageNotFoundError, version
from typing import Any
from xml.etree import ElementTree as ET
from zoneinfo import ZoneInfo

from bt_orchestrator.view.drawing.documents.style import STYLE
from bt_orchestrator.view.drawing.svg import xml_text

_SVG = '{http://www.w3.org/2000/svg}'


class Html:
    """An element that others are put into."""

    def __init__(self, element: ET.Element) -> None:
        self._element = element

    def add(self, name: str, text: str = '', **attributes: Any) -> Html:
        """Add an element.

        In attribute names an underscore becomes a hyphen (`aria_label`); a trailing one is dropped
        (`class_`).
        """
        named = {
            key.rstrip('_').replace('_', '-'): xml_text(str(value))
            for key, value in attributes.items()
        }
        child = ET.SubElement(self._element, name, named)
        child.text = xml_text(text) or None
        return Html(child)

    def say(self, text: str) -> Html:
        """Add text behind everything that is in it; returns the same element."""
        children = list(self._element)
        if children:
            children[-1].tail = (children[-1].tail or '') + xml_text(text)
        else:
            self._element.text = (self._element.text or '') + xml_text(text)
        return self

    def draw(self, svg: str) -> None:
        """Add a drawing (`drawing.svg`); its names must be unique in the page."""
        drawing = ET.fromstring(svg.partition('?>')[2])
        for element in drawing.iter():
            element.tag = element.tag.removeprefix(_SVG)
        self._element.append(drawing)


def document(title: str, write: Callable[[Html], None], style: str = '') -> str:
    """Return a whole page, which needs no other file.

    :param write: writes what is in it
    :param style: rules beyond those of all documents
    """
    page = ET.Element('html', {'lang': 'en'})
    head = ET.SubElement(page, 'head')
    ET.SubElement(head, 'meta', {'charset': 'utf-8'})
    ET.SubElement(
        head, 'meta', {'name': 'viewport', 'content': 'width=device-width, initial-scale=1'}
    )
    ET.SubElement(head, 'meta', {'name': 'color-scheme', 'content': 'light dark'})
    ET.SubElement(head, 'title').text = xml_text(title)
    ET.SubElement(head, 'style').text = STYLE + style
    body = ET.SubElement(page, 'body')
    write(Html(ET.SubElement(body, 'main')))
    text = ET.tostring(page, encoding='unicode', method='html', short_empty_elements=False)
    return f'<!doctype html>\n{text}\n'


def program() -> str:
    """Return name and version of the program that makes documents."""
    try:
        return f'bt-orchestrator {version("bt_orchestrator")}'
    except PackageNotFoundError:
        return 'bt-orchestrator'


@dataclass(frozen=True)
class Times:
    """How times are written: in the zone of the reader, or else in that of this computer."""

    zone: ZoneInfo | None = None

    def clock(self, time: float) -> str:
        """Write the time of day, as the clock on the wall shows it."""
        return self._at(time).strftime('%H:%M:%S.%f')[:-5]

    def day(self, time: float) -> str:
        """Write the day and the time of day, to the second."""
        return self._at(time).strftime('%Y-%m-%d %H:%M:%S')

    def period(self, begin: float, end: float | None) -> str:
        """Write from when to when something was; the day once, if it is one."""
        if end is None:
            return f'from {self.day(begin)}'
        is_one_day = self.day(begin)[:10] == self.day(end)[:10]
        return f'{self.day(begin)} to {self.day(end)[11:] if is_one_day else self.day(end)}'

    def name(self, time: float) -> str:
        """Name the zone at a moment, as UTC+01:00, and with its own name where it has one."""
        offset = self._at(time).strftime('%z')
        utc = f'UTC{offset[:3]}:{offset[3:]}'
        return utc if self.zone is None else f'{self.zone.key} ({utc})'

    def _at(self, time: float) -> datetime:
        return datetime.fromtimestamp(time, self.zone).astimezone(self.zone)


HERE = Times()
"""In the zone of this computer."""
