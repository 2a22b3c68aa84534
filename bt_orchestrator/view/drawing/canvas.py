"""Places and lines on a drawing, in points from the upper left corner."""

from __future__ import annotations

from dataclasses import dataclass, replace

from bt_orchestrator.view.drawing.label import INK, Label

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


# Places on a page, in points from its upper left corner.

Point = tuple[float, float]


@dataclass(frozen=True)
class Box:
    """A place on the page."""

    left: float
    top: float
    width: float
    height: float

    @property
    def right(self) -> float:
        """Its right edge."""
        return self.left + self.width

    @property
    def bottom(self) -> float:
        """Its lower edge."""
        return self.top + self.height

    @property
    def middle(self) -> float:
        """Half its width."""
        return self.left + self.width / 2

    @property
    def centre(self) -> float:
        """Half its height."""
        return self.top + self.height / 2

    def moved(self, right: float, down: float) -> Box:
        """Return the same box elsewhere."""
        return replace(self, left=self.left + right, top=self.top + down)
