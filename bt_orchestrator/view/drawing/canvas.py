"""Lines on a drawing, in points from the upper left corner, to the right and downwards."""

from __future__ import annotations

from dataclasses import dataclass

from bt_orchestrator.view.drawing.box import Point
from bt_orchestrator.view.drawing.label import Label
from bt_orchestrator.view.drawing.style import INK

CORNER = 5.0
"""Radius of a bend, in points."""

PADDING = 21.6
"""White around the picture, in points: 0.3 inches."""

HEADING = 4.0
"""Points from the upper edge of a frame to its heading."""


@dataclass(frozen=True)
class Stroke:
    """How a line is drawn."""

    colour: str = INK
    width: float = 1.0
    dashed: bool = False
    head: bool = True
    """There is an arrow at its end."""


@dataclass(frozen=True)
class LineLabel:
    """A text at a line, and the place of its middle."""

    label: Label
    at: Point


def towards(start: Point, end: Point, length: float) -> Point:
    """Return a point on the way, at most half-way."""
    x, y = end[0] - start[0], end[1] - start[1]
    whole = (x * x + y * y) ** 0.5
    share = min(length / whole, 0.5) if whole else 0.0
    return round(start[0] + x * share, 1), round(start[1] + y * share, 1)
