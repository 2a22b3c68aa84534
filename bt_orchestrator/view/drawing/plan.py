"""The layout of one section, and of the initialization, in points from the upper left corner.

Graphviz does not keep clusters in order, and a reviewer looks for the order of the belt first: the
layout is worked out here.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from bt_orchestrator.model.script import Repeat, SectionList, Step, Task
from bt_orchestrator.view.drawing.canvas import Box, Point
from bt_orchestrator.view.drawing.card import CARD_WIDTH, Sheet, belt_words, card, last_round
from bt_orchestrator.view.drawing.label import Label
from bt_orchestrator.view.drawing.mark import SLOT_HEIGHT

GAP = 24.0
"""Between the steps of a list, for an arrow."""
PADDING = 10.0
TITLE = 28.0
GROUP_TITLE = 20.0
BAR = 20.0
TRACK_GAP = 12.0
MARGIN = 4.0
IDLE_WIDTH = 110.0
"""Of a section without tasks, unless its slot has to say what stands there."""
LOOP_SIDE = 16.0
"""On both sides of the tasks of a repeat; the way back is on the right."""


@dataclass(frozen=True)
class Placed:
    """A task and its card."""

    task: Task
    card: Label
    box: Box
    belt: str = ''


@dataclass(frozen=True)
class Loop:
    """A repeat: the frame around its tasks, and the way back from the last verdict."""

    repeat: Repeat
    box: Box
    first: Box
    last: Box
    """The card of the last verdict."""
    after: Label
    """The steps after the last round."""
    after_box: Box

    def moved(self, right: float, down: float) -> Loop:
        """Return the same repeat elsewhere."""
        places = ('box', 'first', 'last', 'after_box')
        return replace(self, **{name: getattr(self, name).moved(right, down) for name in places})

    @property
    def way_back(self) -> list[Point]:
        """From the last verdict to the first task."""
        lane = self.first.right + LOOP_SIDE / 2
        # A repeat of one task leads back to the same card.
        start, end = (
            self.last.bottom - self.last.height / 4,
            self.first.top + self.first.height / 4,
        )
        return [(self.last.right, start), (lane, start), (lane, end), (self.first.right, end)]


@dataclass(frozen=True)
class Column:
    """One section, as if it stood in the upper left corner."""

    number: int
    width: float
    height: float
    slot: Box
    cards: tuple[Placed, ...] = ()
    groups: tuple[Box, ...] = ()
    loops: tuple[Loop, ...] = ()
    release: Box | None = None
    joins: tuple[Box, ...] = ()
    """Where two groups meet."""
    arrows: tuple[tuple[Box, Box], ...] = ()
    """From the lower edge of one to the upper edge of the other."""

    def moved(self, right: float, down: float, height: float) -> Column:
        """Return the section elsewhere, as high as its neighbours."""

        def move(box: Box) -> Box:
            return box.moved(right, down)

        return replace(
            self,
            height=height,
            slot=move(self.slot),
            cards=tuple(replace(placed, box=move(placed.box)) for placed in self.cards),
            groups=tuple(map(move, self.groups)),
            loops=tuple(loop.moved(right, down) for loop in self.loops),
            release=None if self.release is None else move(self.release),
            joins=tuple(map(move, self.joins)),
            arrows=tuple((move(box), move(other)) for box, other in self.arrows),
        )


def column(sheet: Sheet, number: int) -> Column:
    """Lay out one section."""
    tasks = sheet.script.sections.get(number)
    stacking = _Stacking(sheet, tasks, number)
    for step in tasks.steps if tasks is not None else ():
        stacking.add(step)
    return stacking.column()


class _Stacking:
    """Puts the steps of a list below each other."""

    def __init__(self, sheet: Sheet, tasks: SectionList | None, number: int) -> None:
        self._sheet = sheet
        self._tasks = tasks
        self._number = number
        steps = tasks.steps if tasks else ()
        idle_width = IDLE_WIDTH if sheet.state is None else CARD_WIDTH
        self._inner = max(map(self._width, steps), default=idle_width)
        self._slot = replace(self._bar(TITLE), height=BAR if sheet.state is None else SLOT_HEIGHT)
        self._bottom = self._slot.bottom
        self._cards: list[Placed] = []
        self._groups: list[Box] = []
        self._loops: list[Loop] = []
        self._release: Box | None = None
        self._joins: list[Box] = []
        self._arrows: list[tuple[Box, Box]] = []
        self._ends = [self._slot]
        self._steps = 0

    def add(self, step: Step) -> None:
        """Add a step below the others, and the release of the belt where the turn ends."""
        tops, ends = self._group(step) if step.is_group else self._tracks(step, self._bottom + GAP)
        self._join(tops)
        self._ends = ends
        self._steps += 1
        assert self._tasks is not None
        if self._steps == self._tasks.turn_steps < len(self._tasks.steps):
            self._release = self._bar(self._bottom + GAP)
            self._join([self._release])
            self._bottom, self._ends = self._release.bottom, [self._release]

    def column(self) -> Column:
        """Return the section."""
        empty = 0 if self._cards else GAP
        return Column(
            self._number,
            self._inner + 2 * PADDING,
            self._bottom + empty + PADDING,
            self._slot,
            tuple(self._cards),
            tuple(self._groups),
            tuple(self._loops),
            self._release,
            tuple(self._joins),
            tuple(self._arrows),
        )

    def _bar(self, top: float) -> Box:
        width = min(self._inner, CARD_WIDTH)
        return Box(PADDING + (self._inner - width) / 2, top, width, BAR)

    def _group(self, step: Step) -> tuple[list[Box], list[Box]]:
        top, width = self._bottom + GAP, self._width(step)
        ends = self._tracks(step, top + GROUP_TITLE)
        self._bottom += PADDING
        left = PADDING + (self._inner - width) / 2
        self._groups.append(Box(left, top, width, self._bottom - top))
        return ends

    def _tracks(self, step: Step, top: float) -> tuple[list[Box], list[Box]]:
        """Place the tracks side by side; returns the first and the last box of each."""
        left = PADDING + (self._inner - self._tracks_width(step)) / 2
        tops, ends = [], []
        for track in step.tracks:
            repeat = self._repeat(track)
            if repeat is None:
                boxes = self._track(step, track, left, top)
            else:
                boxes = [self._loop(repeat, step, track, left, top)]
            tops.append(boxes[0])
            ends.append(boxes[-1])
            left += self._track_width(track) + TRACK_GAP
        self._bottom = max(box.bottom for box in ends)
        return tops, ends

    def _track(self, step: Step, track: Sequence[Task], left: float, top: float) -> list[Box]:
        boxes: list[Box] = []
        for task in track:
            assert self._tasks is not None
            belt = belt_words(self._tasks, step, task)
            label = card(self._sheet, task, belt)
            boxes.append(Box(left, top, CARD_WIDTH, label.height))
            self._cards.append(Placed(task, label, boxes[-1], belt))
            top = boxes[-1].bottom + GAP
        self._arrows += pairwise(boxes)
        return boxes

    def _loop(
        self, repeat: Repeat, step: Step, track: Sequence[Task], left: float, top: float
    ) -> Box:
        """Place a repeat in a frame of its own."""
        inner = left + LOOP_SIDE
        boxes = self._track(step, track, inner, top + GROUP_TITLE)
        verdicts = [box for task, box in zip(track, boxes, strict=True) if task.fails_unless]
        after = last_round(self._sheet, track)
        after_box = Box(inner, boxes[-1].bottom + MARGIN, CARD_WIDTH, after.height)
        width, height = CARD_WIDTH + 2 * LOOP_SIDE, after_box.bottom + MARGIN - top
        box = Box(left, top, width, height)
        self._loops.append(Loop(repeat, box, boxes[0], verdicts[-1], after, after_box))
        return box

    def _repeat(self, track: Sequence[Task]) -> Repeat | None:
        return self._sheet.script.repeat_of.get(track[0].id)

    def _track_width(self, track: Sequence[Task]) -> float:
        return CARD_WIDTH + (0 if self._repeat(track) is None else 2 * LOOP_SIDE)

    def _tracks_width(self, step: Step) -> float:
        return sum(map(self._track_width, step.tracks)) + TRACK_GAP * (len(step.tracks) - 1)

    def _width(self, step: Step) -> float:
        return self._tracks_width(step) + (2 * PADDING if step.is_group else 0)

    def _join(self, tops: Sequence[Box]) -> None:
        """Draw arrows from the ends above; those of two groups meet in a point."""
        if len(self._ends) > 1 and len(tops) > 1:
            lowest = max(end.bottom for end in self._ends) + PADDING
            point = Box(PADDING + self._inner / 2, lowest + GAP / 3, 0, 0)
            self._joins.append(point)
            self._arrows += [(end, point) for end in self._ends]
            self._ends = [point]
        self._arrows += [(end, top) for end in self._ends for top in tops]


# --- initialization ---------------------------------------------------------------------------

LEVEL_LENGTH = 5
"""Initialization tasks side by side."""


def initialization(sheet: Sheet) -> tuple[Placed, ...]:
    """Lay out the initialization: a task is below all that come before it."""
    placed: list[Placed] = []
    top = TITLE
    for tasks in _lines(sheet):
        cards = [card(sheet, task) for task in tasks]
        for number, (task, label) in enumerate(zip(tasks, cards, strict=True)):
            left = PADDING + number * (CARD_WIDTH + TRACK_GAP)
            placed.append(Placed(task, label, Box(left, top, CARD_WIDTH, label.height)))
        top += max(label.height for label in cards) + GAP
    return tuple(placed)


def _lines(sheet: Sheet) -> Iterator[list[Task]]:
    levels = _levels(sheet)
    for level in range(max(levels.values(), default=-1) + 1):
        tasks = [task for task in sheet.script.initialization if levels[task.id] == level]
        for start in range(0, len(tasks), LEVEL_LENGTH):
            yield tasks[start : start + LEVEL_LENGTH]


def _levels(sheet: Sheet) -> Mapping[str, int]:
    """Count how many tasks come one after the other before each; dependencies have no circle."""
    levels = {task.id: 0 for task in sheet.script.initialization}
    for _ in levels:
        for dependency in sheet.script.initialization_dependencies:
            levels[dependency.downstream] = max(
                levels[dependency.downstream], levels[dependency.upstream] + 1
            )
    return levels
