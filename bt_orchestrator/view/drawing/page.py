"""The layout of a whole page: header, rows of sections, and the lines between them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate, pairwise
from typing import NamedTuple

from bt_orchestrator.model.script import Dependency, index_task
from bt_orchestrator.view.drawing.canvas import Box, Point
from bt_orchestrator.view.drawing.card import CARD_WIDTH, Sheet, card
from bt_orchestrator.view.drawing.legend import TITLE_WIDTH, legend_width
from bt_orchestrator.view.drawing.plan import (
    GAP,
    PADDING,
    TITLE,
    Column,
    Placed,
    column,
    initialization,
)

LONGEST_ROW = 1900.0
"""Points: six sections, two of them with a group, have room. A longer belt has several rows."""
LABEL_HEIGHT = 28.0
MARGIN = 4.0
EDGE = 14.0
"""From a gutter's or band's end to its first lane."""


class FlagLine(NamedTuple):
    """The way of a flag, and where the middle of its label is."""

    flag: Dependency
    points: list[Point]
    label_at: Point


def label_width(flag: Dependency) -> float:
    """Return about how wide the label of a flag is; letters are up to 7 points wide."""
    return max(110.0, 7 * len(f'flag {flag.flag}'))  # the word is as long in every language


class PageLayout:
    """Everything of a drawing in its place."""

    def __init__(self, sheet: Sheet, title_height: float, legend_height: float) -> None:
        """Lay out a drawing; without title and legend their heights are not used."""
        self.title = Box(0, 0, 0, -GAP) if sheet.is_bare else Box(0, 0, TITLE_WIDTH, title_height)
        self._lanes = Lanes()
        plain = [column(sheet, n) for n in range(1, sheet.cell.conveyor.sections + 1)]
        rows = list(_in_rows(plain))
        self._place = {
            section.number: (r, p) for r, row in enumerate(rows) for p, section in enumerate(row)
        }
        self._flags = [
            (dependency, self._route(sheet, dependency))
            for dependency in sheet.script.dependencies
        ]
        self._turns = [
            self._lanes.route((r, len(row) - 1), (r + 1, 0)) for r, row in enumerate(rows[:-1])
        ]
        self._place_header(sheet)
        self.width, self.height = self._place_rows(rows)
        self.legend = Box(0, self.height + GAP, legend_width(sheet), legend_height)
        if not sheet.is_bare:
            self.width = max(self.width, self.legend.right)
            self.height = self.legend.bottom

    def _route(self, sheet: Sheet, flag: Dependency) -> Route:
        start, end = (
            self._place[sheet.script.section_of(task)] for task in (flag.upstream, flag.downstream)
        )
        return self._lanes.route(start, end, label_width(flag))

    def _place_header(self, sheet: Sheet) -> None:
        """Place initialization and the belt's move side by side."""
        top, left = self.title.bottom + GAP, 0.0
        tasks = initialization(sheet)
        self.initialization_frame: Box | None = None
        if tasks:
            self.initialization_frame = _around(tasks).moved(left, top)
            left = self.initialization_frame.right + GUTTER
        self.initialization = tuple(_moved(placed, 0, top) for placed in tasks)
        task = index_task(sheet.cell)
        label = card(sheet, task)
        move = Placed(task, label, Box(PADDING, TITLE, CARD_WIDTH, label.height))
        self.belt_frame = _around([move]).moved(left, top)
        self.move = _moved(move, left, top)
        frames = [self.belt_frame, self.initialization_frame or self.belt_frame]
        self._header_bottom = max(frame.bottom for frame in frames)

    def _place_rows(self, rows: Sequence[Sequence[Column]]) -> tuple[float, float]:
        """Place the sections; returns width and height of all above the legend."""
        self.columns: list[Column] = []
        self._tops: list[float] = []
        self._gutter_ends: dict[Place, float] = {}
        top, widest = self._header_bottom, max(self.belt_frame.right, self.title.right)
        for r, row in enumerate(rows):
            top += self._lanes.band(r)
            self._tops.append(top)
            height = max(section.height for section in row)
            right = self._lanes.margin - (GUTTER if len(rows) == 1 else 0)
            for p, section in enumerate(row):
                left = right + self._lanes.gutter((r, p))
                self._gutter_ends[r, p] = left
                self.columns.append(section.moved(left, top, height))
                right = left + section.width
            last = (r, len(row))
            self._gutter_ends[last] = right + self._lanes.gutter(last)
            widest = max(widest, self._gutter_ends[last] if self._lanes.has_lines(last) else right)
            top += height
        self._tops.append(top + self._lanes.band(len(rows)))
        return widest, self._tops[-1] if self._lanes.has_lines_above(len(rows)) else top

    def frame(self, section: Column) -> Box:
        """Return the frame of a section."""
        left = section.slot.middle - section.width / 2
        return Box(left, section.slot.top - TITLE, section.width, section.height)

    # --- lines ------------------------------------------------------------------------------

    def belts(self) -> Iterator[tuple[int, list[Point]]]:
        """Yield the belt from each slot to the next one."""
        turns = {route.start: route for route in self._turns}
        for section, following in pairwise(self.columns):
            turn = turns.get(self._place[section.number])
            if turn is not None:
                points = self._points(turn, section.slot, following.slot)
            else:
                y = section.slot.centre
                points = [(section.slot.right, y), (following.slot.left, y)]
            yield section.number, points

    def flags(self) -> Iterator[FlagLine]:
        """Yield the lines of the flags; a label stands on its line, in the gutter."""
        boxes = {placed.task.id: placed.box for column in self.columns for placed in column.cards}
        routes = {flag.flag: route for flag, route in self._flags}
        starts = _apart(
            [
                (routes[flag.flag].start, flag.flag, boxes[flag.upstream])
                for flag, _ in self._flags
            ],
            LABEL_HEIGHT,
        )
        ends = _apart(
            [
                (routes[flag.flag].end, flag.flag, boxes[flag.downstream])
                for flag, _ in self._flags
            ],
            LANE,
        )
        for flag, route in self._flags:
            points = self._points(route, starts[flag.flag], ends[flag.flag])
            beside = self.frame(self._column(flag.upstream)).right
            middle = beside + LABEL_GAP + label_width(flag) / 2
            yield FlagLine(flag, points, (middle, points[0][1] - LABEL_HEIGHT / 2))

    def _column(self, task: str) -> Column:
        return next(c for c in self.columns if any(placed.task.id == task for placed in c.cards))

    def _points(self, route: Route, start: Box, end: Box) -> list[Point]:
        row, position = route.start
        out = self._lane((row, position + 1), route.out)
        points = [(start.right, start.centre), (out, start.centre)]
        if route.below is None:
            side = end.right if route.start == route.end else end.left
            return [*points, (out, end.centre), (side, end.centre)]
        below = self._height(row + 1, route.below)
        points.append((out, below))
        if route.margin is not None and route.above is not None:
            edge = LANE * (route.margin - 1)
            points += [(edge, below), (edge, self._height(route.end[0], route.above))]
        enter = self._lane(route.end, route.enter or 1)
        return [*points, (enter, points[-1][1]), (enter, end.centre), (end.left, end.centre)]

    def _lane(self, gutter: Place, lane: int) -> float:
        return self._gutter_ends[gutter] - EDGE - LANE * (lane - 1)

    def _height(self, band: int, lane: int) -> float:
        return self._tops[band] - EDGE - LANE * (lane - 1)


def _in_rows(columns: Sequence[Column]) -> Iterator[Sequence[Column]]:
    """Break a long belt into rows of about equal length."""
    total = list(accumulate(section.width + GUTTER for section in columns))[-1]
    count = -(-int(total) // int(LONGEST_ROW))
    length = -(-len(columns) // count)
    return (columns[start : start + length] for start in range(0, len(columns), length))


def _apart(lines: Sequence[tuple[Place, str, Box]], distance: float) -> Mapping[str, Box]:
    """Return the places where lines meet the cards of a section, all different.

    :param lines: section, name of the line, card
    """
    boxes: dict[str, Box] = {}
    for place in dict.fromkeys(place for place, _, _ in lines):
        here = sorted(
            ((box, name) for at, name, box in lines if at == place),
            key=lambda pair: (pair[0].centre, pair[0].left),
        )
        heights = _spread([box for box, _ in here], distance)
        for (box, name), height in zip(here, heights, strict=True):
            boxes[name] = replace(box, top=height, height=0)
    return boxes


def _spread(boxes: Sequence[Box], distance: float) -> list[float]:
    """Return a height on each box, from the first to the last, near its centre."""
    heights = [box.centre for box in boxes]
    for n in range(1, len(boxes)):
        heights[n] = max(heights[n], heights[n - 1] + distance)
    heights = [min(y, box.bottom - MARGIN) for y, box in zip(heights, boxes, strict=True)]
    for n in reversed(range(len(boxes) - 1)):
        heights[n] = max(min(heights[n], heights[n + 1] - distance), boxes[n].top + MARGIN)
    return heights


def _around(tasks: Sequence[Placed]) -> Box:
    right = max(task.box.right for task in tasks)
    bottom = max(task.box.bottom for task in tasks)
    return Box(0, 0, right + PADDING, bottom + PADDING)


def _moved(placed: Placed, right: float, down: float) -> Placed:
    return Placed(placed.task, placed.card, placed.box.moved(right, down), placed.belt)


# Routes of flags, and of the belt from row to row, around the sections.
#
# Between two sections is a gutter and below each row of sections a band; each line that runs
# there has a lane of its own.

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
