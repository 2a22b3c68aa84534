"""Bars of the waterfall and of a Pareto, one a row of a table."""

from __future__ import annotations

from fractions import Fraction

from bt_orchestrator.view.drawing.svg import Svg

WIDTH, HEIGHT = 1000.0, 15.0
LEAST = 2.0
"""Width of what is there and would be too narrow to be seen."""


def bar(begin: Fraction | float, end: Fraction | float) -> str:
    """Draw a bar between two parts of the whole, in any order; it ends with the whole."""
    low, high = sorted(min(max(float(part), 0.0), 1.0) for part in (begin, end))
    drawing = Svg.part(WIDTH, HEIGHT)
    if high > low:
        width = max(LEAST, (high - low) * WIDTH)
        drawing.add('rect', x=min(low * WIDTH, WIDTH - LEAST), y=0, width=width, height=HEIGHT)
    return str(drawing)
