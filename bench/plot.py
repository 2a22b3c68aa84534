"""The plot: how dispatch latencies are distributed, and how costs grow."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

from bench.rows import Row, percentile
from bt_orchestrator.view.drawing.canvas import Box
from bt_orchestrator.view.drawing.label import ALARM, SLOT_FILL
from bt_orchestrator.view.drawing.svg import Svg

WIDTH, ROW, LEFT, RIGHT, TOP = 760.0, 30.0, 210.0, 20.0, 50.0
SHORTEST_MS, LONGEST_MS = 0.5, 500.0
MARKS_MS = (1, 2, 5, 10, 20, 50, 100, 200)
PANEL, HEIGHT, BELOW = 350.0, 150.0, 230.0
"""Of a growth curve: width and height of its field, and how much lower the next two are."""

STYLE = (
    f'text{{font-size:12px}}.grid{{stroke:{SLOT_FILL}}}.whole{{stroke:#7a9cc6;stroke-width:4}}'
    f'.half{{stroke:#1f4e8c;stroke-width:10}}.p50{{fill:{ALARM}}}'
    '.curve{fill:none;stroke:#1f4e8c;stroke-width:2}'
)


def draw(rows: Sequence[Row]) -> str:
    """Draw the rows; of latencies p5 to p95 thin, the middle half thick, p50 a dot."""
    notes = next((row.notes for row in rows if 'latencies, s' in row.notes), {})
    lines = [
        (f'{name}, {kind}', values)
        for kind, key in (('sequence', 'latencies, s'), ('wrap', 'wraps, s'))
        for name, values in notes.get(key, {}).items()
    ]
    curves = list(_curves(rows))
    above = TOP + ROW * (len(lines) + 1)
    area = Box(0.0, 0.0, WIDTH + 60, above + BELOW * math.ceil(len(curves) / 2))
    page = Svg.page(area, 'Dispatch latencies, and how costs grow')
    page.add('style', STYLE)
    page.add('text', 'Dispatch latency: a task ends, the next goal arrives (ms)', x=10, y=20)
    _grid(page, above)
    for number, (name, values) in enumerate(lines):
        _distribution(page, TOP + ROW * (number + 0.5), name, [v * 1e3 for v in values])
    for number, (title, xs, ys) in enumerate(curves):
        _curve(page, 60 + number % 2 * 390, above + 40 + number // 2 * BELOW, title, xs, ys)
    return str(page)


def _curves(rows: Sequence[Row]) -> Iterator[tuple[str, list[float], list[float]]]:
    """Yield every growth curve with its title; the first list of a row's curves is the x axis."""
    for row in rows:
        curves: dict[str, Any] = row.notes.get('curves', {})
        (x_name, xs), *others = list(curves.items()) or [('', [])]
        for name, ys in others:
            yield f'{name}, by {x_name}', list(xs), list(ys)


def _grid(page: Svg, height: float) -> None:
    for mark in MARKS_MS:
        x = _x(mark)
        page.add('line', x1=x, x2=x, y1=TOP - 5, y2=height - ROW, class_='grid')
        page.add('text', str(mark), x=x, y=TOP - 10, text_anchor='middle')


def _distribution(page: Svg, y: float, name: str, values: Sequence[float]) -> None:
    page.add('text', name, x=LEFT + 20, y=y + 4, text_anchor='end')
    for kind, low, high in (('whole', 0.05, 0.95), ('half', 0.25, 0.75)):
        from_x, to_x = _x(percentile(values, low)), _x(percentile(values, high))
        page.add('line', x1=from_x, x2=to_x, y1=y, y2=y, class_=kind)
    page.add('circle', cx=_x(percentile(values, 0.5)), cy=y, r=4, class_='p50')


def _curve(
    page: Svg, x: float, y: float, title: str, xs: Sequence[float], ys: Sequence[float]
) -> None:
    """Draw a curve over axes that begin at 0."""
    right, top = max(xs), max(ys) or 1.0
    page.add('text', title, x=x, y=y - 12)
    for share in (0.0, 0.5, 1.0):
        level = y + HEIGHT * (1 - share)
        page.add('line', x1=x, x2=x + PANEL - 60, y1=level, y2=level, class_='grid')
        page.add('text', f'{top * share:.3g}', x=x - 6, y=level + 4, text_anchor='end')
        at = x + (PANEL - 60) * share
        page.add('text', f'{right * share:g}', x=at, y=y + HEIGHT + 18, text_anchor='middle')
    points = ' '.join(
        f'{x + (PANEL - 60) * px / right:.1f},{y + HEIGHT * (1 - py / top):.1f}'
        for px, py in zip(xs, ys, strict=True)
    )
    page.add('polyline', points=points, class_='curve')


def _x(ms: float) -> float:
    share = math.log(max(ms, SHORTEST_MS) / SHORTEST_MS) / math.log(LONGEST_MS / SHORTEST_MS)
    return LEFT + 40 + share * (WIDTH - LEFT - RIGHT)
