"""Patterns, colours, text sizes and legend of a Gantt chart; bars differ in form first."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from bt_orchestrator.model.wait import WaitKind
from bt_orchestrator.view.drawing.canvas import Point
from bt_orchestrator.view.drawing.gantt import Gantt
from bt_orchestrator.view.drawing.label import (
    ALARM,
    BAR_FILL,
    BELT,
    FAINT,
    PAPER,
    RULE,
    SECTION_FILL,
    SLOT_FILL,
)
from bt_orchestrator.view.drawing.svg import CHARACTER, Svg

SIZES = {
    'title': 16.0,
    'row': 12.0,
    'item': 10.0,
    'task': 9.0,
    'tick': 10.0,
    'ends': 10.0,
    'legend': 11.0,
}
"""Sizes of texts, in pixels, by the class of the text."""

JOB_COLOURS = ('#9ecae1', '#fdd0a2', '#a1d99b', '#bcbddc', '#f4b6c2', '#d9c39a')
"""Fills of tasks, by job in turn; light, for black text on them."""

JOB_LINES = ('#2b6c99', '#b35806', '#2e7d4f', '#54468a', '#a8325a', '#7a5b1f')

WAITS: dict[WaitKind, tuple[str, str]] = {
    WaitKind.ITEM: ('an item', ''),
    WaitKind.JOB: ('a job', 'M0 9 H9'),
    WaitKind.BELT: ('the belt', 'M0 3 H9 M0 8 H9'),
    WaitKind.TURN: ('turns of sections', 'M3 0 V9 M8 0 V9'),
    WaitKind.FLAG: ('a flag', 'M-1 10 L10 -1'),
    WaitKind.ZONE: ('a zone', 'M-1 -1 L10 10'),
    WaitKind.COMPONENT: ('a component', 'M-1 10 L10 -1 M-1 -1 L10 10'),
    WaitKind.READINESS: ('a state topic', 'M4 4 h1.4 v1.4 h-1.4 z'),
    WaitKind.OUT_OF_SERVICE: ('a component out of service', 'M1 1 h7 v7 h-7 z M1 8 L8 1'),
    WaitKind.INITIALIZATION: ('initialization', 'M0 4.5 h5'),
    WaitKind.HOLD: ('an answer to a hold', 'M4.5 0 V9 M0 4.5 H9'),
    WaitKind.PAUSE: ('resume', 'M2 1 V7 M5 1 V7'),
    WaitKind.RETRY_DELAY: ('a retry', 'M1 7 L4.5 2 L8 7'),
    WaitKind.CELL_STATE: ('the cell', 'M2 2 h5 v5 h-5 z'),
}
"""The cause of each kind of wait, and its pattern in a square of 9."""

_RULES = f"""
.band {{ fill: {SECTION_FILL} }}
.grid {{ stroke: {SLOT_FILL}; stroke-width: 1 }}
.tick {{ fill: {FAINT}; text-anchor: middle }}
.item, .task {{ pointer-events: none }}
.cycle {{ stroke-width: 1 }}
.work {{ stroke-width: 1 }}
.forecast_end {{ stroke: {FAINT}; stroke-width: 1.5; stroke-dasharray: 5 3 }}
.end {{ stroke: {BAR_FILL}; stroke-width: 1.5 }}
.ends {{ text-anchor: end }}
.failed {{ stroke: {ALARM}; stroke-width: 2; stroke-dasharray: 4 2 }}
.cross {{ stroke: {ALARM}; stroke-width: 1.5 }}
.move {{ fill: url(#move); stroke: {BAR_FILL}; stroke-width: 1 }}
.wait {{ stroke: {RULE}; stroke-width: 0.6; stroke-dasharray: 2 2 }}
.hatch {{ stroke: {BELT}; stroke-width: 1; fill: none }}
.forecast {{ fill-opacity: 0.4; stroke-opacity: 0.5; stroke-width: 0.7 }}
.hold {{ fill: url(#held); stroke: {ALARM}; stroke-width: 2 }}
"""


def add_style(page: Svg) -> None:
    """Put the rules and patterns that the chart refers to into a drawing."""
    sizes = ''.join(f'.{kind} {{ font-size: {size:g}px }}\n' for kind, size in SIZES.items())
    page.add('style', f'{_RULES}{sizes}.title, .row {{ font-weight: bold }}\n')
    defs = page.add('defs')
    for kind, (_, path) in WAITS.items():
        square = _pattern(defs, f'wait_{kind.value}', 9)
        square.add('rect', width=9, height=9, fill=PAPER)
        if path:
            square.add('path', d=path, class_='hatch')
    move = _pattern(defs, 'move', 10)
    move.add('rect', width=10, height=10, fill=SLOT_FILL)
    move.add('path', d='M2 1 L7 5 L2 9', fill='none', stroke=BAR_FILL)
    held = _pattern(defs, 'held', 8)
    held.add('rect', width=8, height=8, fill='#fde3e6')
    held.add('path', d='M0 8 L8 0 M-2 2 L2 -2 M6 10 L10 6', stroke='#eda3ae', stroke_width=1.2)


def add_text(
    svg: Svg, x: float, y: float, text: str, kind: str, room: float | None = None
) -> bool:
    """Write a text of a class, unless it does not fit into the room; tells whether it did."""
    if room is not None and fitting(text, kind, room) != text:
        return False
    if text:
        svg.add('text', text, x=x, y=y, class_=kind)
    return True


def fitting(text: str, kind: str, room: float) -> str:
    """Return a text, or as much of it as fits into the room; empty if too little fits."""
    most = int(room / (SIZES[kind] * CHARACTER))
    if len(text) <= most:
        return text
    return f'{text[: most - 1]}…' if most >= 3 else ''


def fill_of_wait(kind: WaitKind) -> str:
    """Return the fill of a wait; of a wait for several things, that of the first."""
    return f'url(#wait_{kind.value})'


def _pattern(defs: Svg, name: str, size: int) -> Svg:
    return defs.add('pattern', id=name, width=size, height=size, patternUnits='userSpaceOnUse')


# The legend of a Gantt chart: the kinds of bars that occur in it.

WIDEST = 1000.0
"""Where a line of the legend ends, in pixels."""


class _Entry(NamedTuple):
    text: str
    look: Mapping[str, Any]


def add_legend(
    svg: Svg, gantt: Gantt, letters: Mapping[str, str], place: Point, width: float
) -> None:
    """Draw the legend, line after line.

    :param width: of the page
    """
    group = svg.add('g', id='legend')
    left, y = place
    x, widest = left, min(WIDEST, width - left)
    for entry in _entries(gantt, letters):
        room = 34.0 + len(entry.text) * SIZES['legend'] * CHARACTER + 14.0
        if x + room > widest and x > left:
            x, y = left, y + 21.0
        group.add('rect', x=x, y=y, width=26, height=12, **entry.look)
        add_text(group, x + 32.0, y + 10.0, entry.text, 'legend')
        x += room


def _entries(gantt: Gantt, letters: Mapping[str, str]) -> Iterator[_Entry]:
    for number, job in enumerate(gantt.jobs):
        colour = number % len(JOB_COLOURS)
        look = {'fill': JOB_COLOURS[colour], 'stroke': JOB_LINES[colour], 'class_': 'work'}
        short = f' (items {letters[job]}.1 …)' if letters[job] else ''
        yield _Entry(f'task of {job}{short}', look)
    outline = {'fill': PAPER, 'stroke': FAINT, 'rx': 3, 'class_': 'cycle'}
    if not gantt.by_component:
        yield _Entry('item in hand', outline)
    bars = [bar for row in gantt.rows for bar in row.tasks]
    if any(bar.key.job is None for bar in bars) or not gantt.is_past:
        yield _Entry('index move', {'class_': 'move'})
    if any(row.forecast for row in gantt.rows):
        light = {'fill': JOB_COLOURS[0], 'stroke': JOB_LINES[0], 'class_': 'work forecast'}
        yield _Entry('forecast, above', light)
    if any(bar.failed for bar in bars):
        failed = {'fill': PAPER, 'class_': 'work failed'}
        yield _Entry('attempt that failed', failed)
    if any(row.holds for row in gantt.rows):
        yield _Entry('hold', {'class_': 'hold'})
    waited = {span.causes[0].kind for row in gantt.rows for span in row.waits}
    for kind, (what, _) in WAITS.items():
        if kind in waited:
            yield _Entry(f'waits for {what}', {'fill': fill_of_wait(kind), 'class_': 'wait'})
