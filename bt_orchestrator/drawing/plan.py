"""The layout of one section, and of the initialization, in points from the upper left corner.

`dot` does not keep clusters in order, and the order of the belt is what a reviewer looks for
first. So the places are worked out here; Graphviz draws.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from bt_orchestrator.drawing.box import Box
from bt_orchestrator.drawing.card import CARD_WIDTH, Sheet, belt_words, card
from bt_orchestrator.drawing.label import Label
from bt_orchestrator.drawing.mark import SLOT_HEIGHT
from bt_orchestrator.model.script import SectionList, Step, Task

GAP = 24.0
"""Between the steps of a list, for an arrow."""
PADDING = 10.0
TITLE = 24.0
GROUP_TITLE = 18.0
BAR = 20.0
TRACK_GAP = 12.0


@dataclass(frozen=True)
class Placed:
    """A task and its card."""

    task: Task
    card: Label
    box: Box
    belt: str = ''


@dataclass(frozen=True)
class Column:
    """One section, as if it stood in the upper left corner."""

    number: int
    width: float
    height: float
    slot: Box
    cards: tuple[Placed, ...] = ()
    groups: tuple[Box, ...] = ()
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
            cards=tuple(replace(one, box=move(one.box)) for one in self.cards),
            groups=tuple(map(move, self.groups)),
            release=None if self.release is None else move(self.release),
            joins=tuple(map(move, self.joins)),
            arrows=tuple((move(one), move(other)) for one, other in self.arrows),
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
        self._inner = max(map(_width, tasks.steps), default=CARD_WIDTH) if tasks else CARD_WIDTH
        self._slot = replace(self._bar(TITLE), height=BAR if sheet.state is None else SLOT_HEIGHT)
        self._bottom = self._slot.bottom
        self._cards: list[Placed] = []
        self._groups: list[Box] = []
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
            self._release,
            tuple(self._joins),
            tuple(self._arrows),
        )

    def _bar(self, top: float) -> Box:
        return Box(PADDING + (self._inner - CARD_WIDTH) / 2, top, CARD_WIDTH, BAR)

    def _group(self, step: Step) -> tuple[list[Box], list[Box]]:
        top, width = self._bottom + GAP, _width(step)
        ends = self._tracks(step, top + GROUP_TITLE)
        self._bottom += PADDING
        left = PADDING + (self._inner - width) / 2
        self._groups.append(Box(left, top, width, self._bottom - top))
        return ends

    def _tracks(self, step: Step, top: float) -> tuple[list[Box], list[Box]]:
        """Place the tracks side by side; returns the first and the last box of each."""
        width = len(step.tracks) * (CARD_WIDTH + TRACK_GAP) - TRACK_GAP
        left = PADDING + (self._inner - width) / 2
        tops, ends = [], []
        for track in step.tracks:
            boxes = self._track(step, track, left, top)
            tops.append(boxes[0])
            ends.append(boxes[-1])
            left += CARD_WIDTH + TRACK_GAP
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

    def _join(self, tops: Sequence[Box]) -> None:
        """Draw arrows from the ends above; those of two groups meet in a point."""
        if len(self._ends) > 1 and len(tops) > 1:
            lowest = max(end.bottom for end in self._ends) + PADDING
            point = Box(PADDING + self._inner / 2, lowest + GAP / 3, 0, 0)
            self._joins.append(point)
            self._arrows += [(end, point) for end in self._ends]
            self._ends = [point]
        self._arrows += [(end, top) for end in self._ends for top in tops]


def _width(step: Step) -> float:
    cards = len(step.tracks) * (CARD_WIDTH + TRACK_GAP) - TRACK_GAP
    return cards + 2 * PADDING if step.is_group else cards


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
        for one in sheet.script.initialization_dependencies:
            levels[one.downstream] = max(levels[one.downstream], levels[one.upstream] + 1)
    return levels
