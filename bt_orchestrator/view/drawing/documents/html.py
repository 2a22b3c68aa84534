"""The writer of HTML: elements with escaped text, and the page around them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime
from importlib.metadata import PackageNotFoundError, version
from typing import Any
from xml.etree import ElementTree as ET
from zoneinfo import ZoneInfo

from bt_orchestrator.view.drawing.svg import xml_text
from bt_orchestrator.view.drawing.wording import ENGLISH, Wording

_SVG = '{http://www.w3.org/2000/svg}'


class Html:
    """An element that others are put into."""

    def __init__(self, element: ET.Element, words: Wording = ENGLISH) -> None:
        self._element = element
        self.words = words
        """The language of its texts."""

    def add(self, name: str, text: str = '', **attributes: Any) -> Html:
        """Add an element with words, in the language of the page."""
        return self.quote(name, self.words.report(text), **attributes)

    def quote(self, name: str, text: str, **attributes: Any) -> Html:
        """Add an element with a name, or with the words of a person, unchanged.

        In attribute names an underscore becomes a hyphen (`aria_label`); a trailing one is dropped
        (`class_`).
        """
        named = {
            key.rstrip('_').replace('_', '-'): xml_text(str(value))
            for key, value in attributes.items()
        }
        child = ET.SubElement(self._element, name, named)
        child.text = xml_text(text) or None
        return Html(child, self.words)

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


def document(
    title: str, write: Callable[[Html], None], style: str = '', words: Wording = ENGLISH
) -> str:
    """Return a whole page, which needs no other file.

    :param write: writes what is in it
    :param style: rules beyond those of all documents
    """
    page = ET.Element('html', {'lang': words.language})
    head = ET.SubElement(page, 'head')
    ET.SubElement(head, 'meta', {'charset': 'utf-8'})
    ET.SubElement(
        head, 'meta', {'name': 'viewport', 'content': 'width=device-width, initial-scale=1'}
    )
    ET.SubElement(head, 'meta', {'name': 'color-scheme', 'content': 'light dark'})
    ET.SubElement(head, 'title').text = xml_text(title)
    ET.SubElement(head, 'style').text = STYLE + style
    body = ET.SubElement(page, 'body')
    write(Html(ET.SubElement(body, 'main'), words))
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


# The style of all documents: screens, light and dark, narrow and wide, and paper.

STYLE = """
:root {
  --ground: #eef0f2; --sheet: #ffffff; --panel: #f5f6f8; --line: #d5dae0; --strong: #98a2ad;
  --ink: #1c2126; --quiet: #57616b; --bar: #6f8296; --wait: #c9d1d9;
  --good: #1d6b3f; --good-ground: #e0f2e7; --bad: #a8101c; --bad-ground: #fbe3e4;
  --warn: #7a4a00; --warn-ground: #fdf0d5; --note: #1d4f87; --note-ground: #e4eefa;
}
@media (prefers-color-scheme: dark) {
  :root {
    --ground: #16191c; --sheet: #1f2327; --panel: #282d32; --line: #3a4148; --strong: #77828d;
    --ink: #e6e9ec; --quiet: #a7b1bb; --bar: #8aa0b6; --wait: #4a545e;
    --good: #7fd6a2; --good-ground: #173524; --bad: #ff9a9a; --bad-ground: #45191d;
    --warn: #f3c265; --warn-ground: #3f2f10; --note: #9cc6f5; --note-ground: #182b40;
  }
}
* { box-sizing: border-box }
html { background: var(--ground); color: var(--ink); -webkit-text-size-adjust: 100% }
body {
  margin: 0; font: 15px/1.45 system-ui, "Segoe UI", Roboto, "Noto Sans", "DejaVu Sans", sans-serif;
}
main { max-width: 1080px; margin: 0 auto; padding: 24px 16px 48px }
article, .sheet {
  background: var(--sheet); border: 1px solid var(--line); border-radius: 8px;
  padding: 28px 32px; margin-bottom: 24px;
}
h1 { font-size: 30px; line-height: 1.15; margin: 2px 0 0; overflow-wrap: anywhere }
h2 {
  font-size: 13px; letter-spacing: .06em; text-transform: uppercase; color: var(--quiet);
  margin: 32px 0 10px; padding-bottom: 6px; border-bottom: 2px solid var(--line);
}
h3 { font-size: 16px; margin: 0 }
p { margin: 0 }
a { color: var(--note) }
.kind {
  font-size: 12px; letter-spacing: .1em; text-transform: uppercase; color: var(--quiet);
}
.head { display: flex; flex-wrap: wrap; gap: 12px 24px; align-items: flex-start }
.head > :first-child { flex: 1 1 320px; min-width: 0 }
.sub { color: var(--quiet); margin-top: 6px }
.badge {
  font-weight: 700; font-size: 17px; padding: 8px 16px; border-radius: 6px;
  border: 2px solid currentColor; white-space: nowrap;
  color: var(--note); background: var(--note-ground);
}
.badge.good { color: var(--good); background: var(--good-ground) }
.badge.bad { color: var(--bad); background: var(--bad-ground) }
.badge.warn { color: var(--warn); background: var(--warn-ground) }
.notice {
  margin-top: 16px; padding: 10px 14px; border-left: 4px solid var(--warn);
  background: var(--warn-ground); color: var(--ink); border-radius: 0 6px 6px 0;
}
.notice.bad { border-color: var(--bad); background: var(--bad-ground) }
.tiles { display: grid; grid-template-columns: repeat(auto-fit, minmax(104px, 1fr)); gap: 10px;
  margin-top: 20px }
.tile { background: var(--panel); border-radius: 6px; padding: 10px 14px }
.tile b { display: block; font-size: 21px; line-height: 1.25; font-variant-numeric: tabular-nums }
.tile span { color: var(--quiet); font-size: 13px }
.tile.bad b { color: var(--bad) }
dl.facts {
  display: grid; grid-template-columns: max-content 1fr; gap: 5px 18px; margin: 18px 0 0;
}
dl.facts dt { color: var(--quiet) }
dl.facts dd { margin: 0; overflow-wrap: anywhere }
.picture {
  overflow-x: auto; background: #ffffff; border: 1px solid var(--line); border-radius: 6px;
}
.picture svg { display: block; width: 100%; min-width: 720px; height: auto }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums }
th {
  text-align: left; font-weight: 600; font-size: 12px; color: var(--quiet);
  padding: 6px 10px 6px 0; border-bottom: 1px solid var(--strong); white-space: nowrap;
}
td { padding: 7px 10px 7px 0; border-bottom: 1px solid var(--line); vertical-align: top }
td.number, th.number { text-align: right; white-space: nowrap }
td.time { white-space: nowrap; color: var(--quiet) }
.bar { width: 34% }
.bar i {
  display: block; height: 11px; margin-top: 5px; background: var(--wait); border-radius: 2px;
  min-width: 1px;
}
.bar i.busy { background: var(--bar) }
.chapter { margin-top: 22px; break-inside: auto }
.chapter > header {
  display: flex; flex-wrap: wrap; gap: 2px 16px; align-items: baseline;
  background: var(--panel); padding: 8px 12px; border-radius: 6px; break-after: avoid;
}
.chapter > header p { color: var(--quiet); font-size: 13px }
.story { table-layout: fixed }
.story th:nth-child(1) { width: 112px } .story th:nth-child(2) { width: 24% }
.story th:nth-child(3) { width: 19% } .story th:nth-child(4) { width: 76px }
.story td:first-child, .story th:first-child { padding-left: 12px }
.story .what b { font-weight: 600; overflow-wrap: anywhere }
.story .what span { color: var(--quiet); display: block; font-size: 13px; overflow-wrap: anywhere }
.story .waited { color: var(--quiet); font-size: 13px }
.story .waited b { color: var(--ink); font-weight: 600 }
.story .words { overflow-wrap: anywhere }
.story .more { font-size: 13px; color: var(--quiet); margin-top: 3px }
.story .more b { font-weight: 600 }
.story tr.is-task.failed .words > p:first-child { color: var(--bad); font-weight: 600 }
.story tr.is-hold td { background: var(--bad-ground) }
.story tr.is-decision td { background: var(--note-ground) }
.story tr.is-restart td { background: var(--warn-ground) }
.story tr.is-end td { font-weight: 600 }
.mark { display: inline-block; width: 1.3em; font-weight: 700 }
.quote::before { content: "\\201c" } .quote::after { content: "\\201d" }
footer { color: var(--quiet); font-size: 12px; margin-top: 28px; border-top: 1px solid var(--line);
  padding-top: 10px; overflow-wrap: anywhere }
@media screen and (max-width: 720px) {
  main { padding: 0 }
  article, .sheet { border-radius: 0; border-width: 0 0 1px; padding: 20px 16px }
  h1 { font-size: 25px }
  .story thead { display: none }
  .story tr { display: grid; grid-template-columns: 1fr auto; border-bottom: 1px solid var(--line);
    padding: 8px 10px }
  .story td { border: 0; padding: 1px 0 }
  .story td:first-child { padding-left: 0 }
  .story td.waited { order: 1; grid-column: 1 / -1 }
  .story td.time { order: 2 } .story td.number { order: 3 }
  .story td.what { order: 4; grid-column: 1 / -1 }
  .story td.words { order: 5; grid-column: 1 / -1 }
  .story tr.is-hold, .story tr.is-decision, .story tr.is-restart { background: var(--panel) }
}
@media print {
  :root {
    --ground: #fff; --sheet: #fff; --panel: #f2f3f5; --line: #c9ced4; --strong: #666;
    --ink: #000; --quiet: #444; --bar: #555; --wait: #bbb;
    --good: #0d5a30; --good-ground: #fff; --bad: #9a0b17; --bad-ground: #fdeeee;
    --warn: #6a4000; --warn-ground: #fdf6e6; --note: #17406e; --note-ground: #eff5fc;
    color-scheme: light;
  }
  @page { size: A4; margin: 14mm 14mm 16mm }
  body { font-size: 9pt }
  .story th:nth-child(1) { width: 90px } .story th:nth-child(2) { width: 21% }
  .story th:nth-child(3) { width: 19% } .story th:nth-child(4) { width: 54px }
  .story .what span, .story .waited, .story .more { font-size: 8pt }
  main { max-width: none; padding: 0 }
  article, .sheet { border: 0; padding: 0; margin: 0 }
  article + article { break-before: page }
  h1 { font-size: 20pt } h2 { margin-top: 16pt; break-after: avoid }
  tr, .tile, .picture, dl.facts, .notice { break-inside: avoid }
  thead { display: table-header-group }
  .picture { border: 0 } .picture svg { min-width: 0 }
  * { print-color-adjust: exact; -webkit-print-color-adjust: exact }
}
"""
