"""Routes of flags, and of the belt from row to row, around the sections.

Between two sections is a gutter and below each row of sections a band; each line that runs there
has a lane of its own.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

Place = tuple[int, int]
"""Row and position in the row, from 0."""

LANE = 8.0
LABEL_GAP = 10.0
"""Left and right of a label."""
GUTTER = 30.0
BAND = 24.0


@dataclass(frozen=True)
class Route:
    """A line from one section to another, lane by lane."""

    start: Place
    end: Place
    out: int
    """Lane in the gutter right of the start."""
    below: int | None = None
    """Lane in the band below the start's row; None: start and end are neighbours."""
    margin: int | None = None
    """Lane at the left edge of the page, if rows are passed."""
    above: int | None = None
    """Lane in the band above the end's row, if rows are passed."""
    enter: int | None = None
    """Lane in the gutter left of the end; None where it is the one right of the start."""


class Lanes:
    """Hands out lanes, and tells how much room they need."""

    def __init__(self) -> None:
        self._used: Counter[object] = Counter()
        self._labels: dict[Place, float] = {}

    def route(self, start: Place, end: Place, label_width: float = 0) -> Route:
        """Find a way; a label stands in the gutter where the line begins."""
        row, position = start
        gutter = (row, position + 1)
        self._labels[gutter] = max(label_width, self._labels.get(gutter, 0))
        out = self._take(gutter)
        if end in (start, gutter):
            return Route(start, end, out)
        below = self._take(('band', row + 1))
        if end[0] in (row, row + 1):
            return Route(start, end, out, below, enter=self._take(end))
        margin, above = self._take('margin'), self._take(('band', end[0]))
        return Route(start, end, out, below, margin, above, self._take(end))

    def gutter(self, place: Place) -> float:
        """Return the width of the gutter left of a place."""
        width = self._labels.get(place, 0)
        label = width + 2 * LABEL_GAP if width else 0
        return GUTTER + label + LANE * self._used[place]

    def band(self, row: int) -> float:
        """Return the height of the band above a row."""
        return BAND + LANE * self._used['band', row]

    def has_lines(self, place: Place) -> bool:
        """Tell whether a line runs in the gutter left of a place."""
        return self._used[place] > 0

    def has_lines_above(self, row: int) -> bool:
        """Tell whether a line runs in the band above a row."""
        return self._used['band', row] > 0

    @property
    def margin(self) -> float:
        """Width of the left edge."""
        return LANE * self._used['margin']

    def _take(self, where: object) -> int:
        self._used[where] += 1
        return self._used[where]
