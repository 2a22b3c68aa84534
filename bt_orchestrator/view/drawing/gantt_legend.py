"""The legend of a Gantt chart: the kinds of bars that occur in it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from bt_orchestrator.view.drawing.box import Point
from bt_orchestrator.view.drawing.gantt import Gantt
from bt_orchestrator.view.drawing.gantt_style import (
    JOB_COLOURS,
    JOB_LINES,
    SIZES,
    WAITS,
    add_text,
    fill_of_wait,
)
from bt_orchestrator.view.drawing.style import FAINT, PAPER
from bt_orchestrator.view.drawing.svg import CHARACTER, Svg

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
