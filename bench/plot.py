"""The plot: how dispatch latencies are distributed, one line a candidate."""

from __future__ import annotations

import math
from collections.abc import Sequence

from bench.rows import Row, percentile
from bt_orchestrator.sim.svg import Svg

WIDTH, ROW, LEFT, RIGHT, TOP = 760.0, 30.0, 170.0, 20.0, 50.0
SHORTEST_MS, LONGEST_MS = 0.5, 500.0
MARKS_MS = (1, 2, 5, 10, 20, 50, 100, 200)

STYLE = (
    'text{font:12px sans-serif;fill:#222}.grid{stroke:#ddd}.whole{stroke:#7a9cc6;stroke-width:4}'
    '.half{stroke:#1f4e8c;stroke-width:10}.p50{fill:#c0392b}'
)


def draw(rows: Sequence[Row]) -> str:
    """Draw what the rows have of latencies; p5 to p95 thin, the middle half thick, p50 a dot."""
    found = next((row.notes for row in rows if 'latencies, s' in row.notes), {})
    lines = [
        (f'{name}, {kind}', values)
        for kind, key in (('sequence', 'latencies, s'), ('wrap', 'wraps, s'))
        for name, values in found.get(key, {}).items()
    ]
    height = TOP + ROW * (len(lines) + 1)
    page = Svg.page(WIDTH + 60, height)
    page.add('style', STYLE)
    page.add('rect', width='100%', height='100%', fill='#fff')
    page.add('text', 'Dispatch latency: a task ends, the next goal arrives (ms)', x=10, y=20)
    _grid(page, height)
    for number, (name, values) in enumerate(lines):
        _distribution(page, TOP + ROW * (number + 0.5), name, [v * 1e3 for v in values])
    return str(page)


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


def _x(ms: float) -> float:
    share = math.log(max(ms, SHORTEST_MS) / SHORTEST_MS) / math.log(LONGEST_MS / SHORTEST_MS)
    return LEFT + 40 + share * (WIDTH - LEFT - RIGHT)
