"""A script as its process: the line of sections, with what couples them.

Read like a page: what comes before the line on top, then the belt from left to right with each
section's list below its slot, in several rows where the belt is long.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import graphviz

from bt_orchestrator.drawing.canvas import Canvas
from bt_orchestrator.drawing.card import Sheet, details
from bt_orchestrator.drawing.legend import legend, title
from bt_orchestrator.drawing.line_state import SectionMark
from bt_orchestrator.drawing.mark import slot_label, slot_tooltip
from bt_orchestrator.drawing.page import FlagLine, Page
from bt_orchestrator.drawing.plan import Box, Column, Placed
from bt_orchestrator.drawing.text import (
    BAR_FILL,
    BELT,
    FAINT,
    FLAG,
    GROUP_FILL,
    INK,
    PAPER,
    SECTION_FILL,
    SLOT_FILL,
    entry,
    font,
    lines,
    table,
    tooltip,
)
from bt_orchestrator.model.script import Dependency

_INITIALIZATION = 'a section begins the first item of an order when its components are initialized'
_BELT = 'moves every item by one slot, when every section has let it go'
_GROUP = 'these start together; the group ends when all of them ended'


def line(sheet: Sheet) -> graphviz.Digraph:
    """Draw a script as a process; every place is fixed, so the engine is `neato -n2`."""
    head, key = title(sheet), legend(sheet)
    page = Page(sheet, head.height, key.height)
    canvas = Canvas(sheet.script.name, page.width, page.height)
    canvas.node(canvas.graph, 'title', head.label, page.title, tooltip='title')
    canvas.node(canvas.graph, 'legend', key.label, page.legend, tooltip='legend')
    drawing = _Drawing(sheet, page, canvas)
    drawing.header()
    for column in page.columns:
        drawing.section(column)
    drawing.belts()
    drawing.flags()
    return canvas.graph


class _Drawing:
    """Puts the parts of a page on a canvas."""

    def __init__(self, sheet: Sheet, page: Page, canvas: Canvas) -> None:
        self._sheet = sheet
        self._page = page
        self._canvas = canvas
        self._names: dict[Box, str] = {}
        """Nodes by their place."""

    def header(self) -> None:
        """Draw the initialization and the belt's move."""
        page = self._page
        if page.initialization_frame is not None:
            words = 'Initialization, per order'
            box = page.initialization_frame
            with self._frame('initialization', words, box, _INITIALIZATION) as frame:
                self._cards(frame, page.initialization)
        boxes = {one.task.id: one.box for one in page.initialization}
        for one in self._sheet.script.initialization_dependencies:
            self._arrow(boxes[one.upstream], boxes[one.downstream])
        with self._frame('belt', 'Belt, after every beat', page.belt_frame, _BELT) as frame:
            self._cards(frame, [page.move])

    def section(self, column: Column) -> None:
        """Draw one section."""
        number = column.number
        name = f'section.{number}'
        box = self._page.frame(column)
        with self._frame(name, self._heading(number), box, self._about(number)) as frame:
            for count, group in enumerate(column.groups, 1):
                self._group(frame, f'{name}.group.{count}', group)
            self._slot(frame, column)
            if column.release is not None:
                self._release(frame, f'{name}.release', column.release)
            for count, join in enumerate(column.joins, 1):
                self._join(frame, f'{name}.join.{count}', join)
            self._cards(frame, column.cards)
            if not column.cards:
                self._idle(frame, name, column.slot)
        for one, other in column.arrows:
            self._arrow(one, other)

    def belts(self) -> None:
        """Draw the belt from slot to slot."""
        for number, points in self._page.belts():
            self._canvas.line(
                f'slot.{number}',
                f'slot.{number + 1}',
                points,
                id=f'belt.{number}',
                edgetooltip=f'the belt, from section {number} to section {number + 1}',
                penwidth='5',
                arrowsize='0.6',
                **self._belt_style(),
            )

    def flags(self) -> None:
        """Draw the flags from task to task."""
        for one in self._page.flags():
            self._flag(one)

    def _belt_style(self) -> dict[str, Any]:
        state = self._sheet.state
        if state is None or not state.belt_moves:
            return {'color': BELT}
        return {'color': INK, 'style': 'dashed'}

    # --- parts ------------------------------------------------------------------------------

    def _heading(self, number: int) -> str:
        script = self._sheet.script
        roles = [('source', script.source), ('sink', script.sink)]
        return ' \u00b7 '.join([f'Section {number}', *(r for r, at in roles if at == number)])

    def _about(self, number: int) -> str:
        components = self._sheet.cell.components.values()
        here = ', '.join(one.name for one in components if number in one.sections)
        return tooltip([self._heading(number), f'components: {here or "none"}'])

    def _frame(self, name: str, words: str, box: Box, hint: str) -> graphviz.Digraph:
        label = table([[entry(font(words, size=13, bold=True), width=box.width - 12)]])
        graph, fill = self._canvas.graph, SECTION_FILL
        return self._canvas.group(graph, name, label, box, fillcolor=fill, tooltip=hint)

    def _group(self, frame: graphviz.Digraph, name: str, box: Box) -> None:
        label = table([[entry(font('in parallel', italic=True), width=box.width - 12)]])
        fill = GROUP_FILL
        with self._canvas.group(frame, name, label, box, fillcolor=fill, tooltip=_GROUP):
            pass  # its members are drawn with the section, in the order of the list

    def _cards(self, frame: graphviz.Digraph, cards: Iterable[Placed]) -> None:
        for one in cards:
            name = self._names[one.box] = f'task.{one.task.id}'
            hint = details(self._sheet, one.task, one.belt)
            self._canvas.node(frame, name, one.card.label, one.box, tooltip=hint)

    def _slot(self, frame: graphviz.Digraph, column: Column) -> None:
        words = f'slot {column.number}'
        name = self._names[column.slot] = f'slot.{column.number}'
        label, hint = _bar(words, INK, SLOT_FILL, column.slot), [f'{words} of the belt']
        if self._sheet.state is not None:
            mark = self._sheet.state.sections.get(column.number, SectionMark())
            label = slot_label(column.number, mark, column.slot.width, column.slot.height)
            hint += slot_tooltip(mark)
        self._canvas.node(frame, name, label, column.slot, tooltip=tooltip(hint))

    def _release(self, frame: graphviz.Digraph, name: str, box: Box) -> None:
        self._names[box] = name
        hint = 'from here on the belt may move; what is below runs meanwhile'
        label = _bar('belt released', PAPER, BAR_FILL, box)
        self._canvas.node(frame, name, label, box, tooltip=hint)

    def _join(self, frame: graphviz.Digraph, name: str, box: Box) -> None:
        self._names[box] = name
        looks = {'shape': 'point', 'width': '0.06', 'color': INK, 'tooltip': _GROUP}
        self._canvas.node(frame, name, '', box, **looks)

    def _idle(self, frame: graphviz.Digraph, section: str, slot: Box) -> None:
        label = table([[entry(font('no task: items pass', colour=FAINT, italic=True))]])
        below = slot.moved(0, slot.height + 4)
        hint = 'the script has no list for this section'
        self._canvas.node(frame, f'{section}.idle', label, below, tooltip=hint)

    def _arrow(self, above: Box, below: Box) -> None:
        points = [(above.middle, above.bottom), (below.middle, below.top)]
        start, end = self._names[above], self._names[below]
        self._canvas.line(start, end, points, head=below.height > 0)

    def _flag(self, one: FlagLine) -> None:
        flag = one.flag
        counts = self._counts(flag)
        name = font(f'flag {flag.flag}', bold=True, colour=FLAG)
        hint = tooltip(_about_flag(flag))
        self._canvas.line(
            f'task.{flag.upstream}',
            f'task.{flag.downstream}',
            one.points,
            label_at=one.label_at,
            label=table([[entry(lines([name, font(counts, size=9, colour=FLAG)]))]]),
            id=f'flag.{flag.flag}',
            edgetooltip=hint,
            labeltooltip=hint,
            color=FLAG,
            style='dashed',
            penwidth='1.6',
        )

    def _counts(self, flag: Dependency) -> str:
        state = self._sheet.state
        if state is None or flag.flag not in state.flags:
            return f'capacity {flag.capacity}, initial {flag.initial}'
        return f'count {state.flags[flag.flag]} of {flag.capacity}'


def _bar(words: str, colour: str, fill: str, box: Box) -> str:
    text = font(words, bold=True, colour=colour)
    middle = entry(text, align='CENTER', width=box.width, height=box.height)
    return table([[middle]], fill=fill)


def _about_flag(flag: Dependency) -> list[str]:
    return [
        f'flag {flag.flag}: capacity {flag.capacity}, initial count {flag.initial}',
        f'{flag.upstream} starts while it is below {flag.capacity}, and adds one after it',
        f'{flag.downstream} starts while it is above 0, and takes one after it',
    ]
