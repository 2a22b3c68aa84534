"""The canvas that a line is drawn on: every part has its place, whatever the file format.

Points count from the upper left corner, to the right and downwards.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from typing import Protocol

from bt_orchestrator.drawing.box import Box, Point
from bt_orchestrator.drawing.label import Label
from bt_orchestrator.drawing.style import INK

CORNER = 5.0
"""Radius of a bend, in points."""

PADDING = 21.6
"""White around the picture, in points: 0.3 inches."""

HEADING = 10.0
"""Points from the upper edge of a frame to the middle of its heading."""


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
    """What is written at a line, and where its middle is."""

    label: Label
    at: Point


class Canvas(Protocol):
    """One picture. Names are unique in it, and are those of the parts in the file.

    `about` is shown, line by line, when a reader points at a part.
    """

    def frame(
        self, name: str, heading: Label, box: Box, fill: str, about: Sequence[str]
    ) -> AbstractContextManager[None]:
        """Draw a frame; what is drawn within the context stands in it."""

    def label(self, name: str, label: Label, box: Box, about: Sequence[str]) -> None:
        """Draw a table of text into a box."""

    def point(self, name: str, box: Box, about: Sequence[str]) -> None:
        """Draw a small dot where lines meet."""

    def line(
        self,
        ends: tuple[str, str],
        points: Sequence[Point],
        stroke: Stroke,
        *,
        name: str = '',
        about: Sequence[str] = (),
        label: LineLabel | None = None,
    ) -> None:
        """Draw a line with round corners from one part to another."""


def towards(start: Point, end: Point, length: float) -> Point:
    """Return a point on the way, at most half-way."""
    x, y = end[0] - start[0], end[1] - start[1]
    whole = (x * x + y * y) ** 0.5
    share = min(length / whole, 0.5) if whole else 0.0
    return round(start[0] + x * share, 1), round(start[1] + y * share, 1)
