"""The drawing of a script as a line of sections, with what couples them.

Read like a page: what comes before the line on top, then the belt from left to right with each
section's list below its slot, in several rows where the belt is long.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.proof.pace import pace
from bt_orchestrator.model.script import Dependency, Script
from bt_orchestrator.view.drawing.canvas import Box, LineLabel, Stroke
from bt_orchestrator.view.drawing.card import ROUND_FILL, Sheet, details, rounds_words
from bt_orchestrator.view.drawing.label import (
    BAR_FILL,
    BELT,
    FAINT,
    FLAG,
    GROUP_FILL,
    INK,
    LINE_HEIGHT,
    LOOP_LINE,
    PAPER,
    SECTION_FILL,
    SLOT_FILL,
    Entry,
    Label,
    Text,
    one_entry,
    wrapped,
)
from bt_orchestrator.view.drawing.legend import legend, title
from bt_orchestrator.view.drawing.line_state import LineState, SectionMark
from bt_orchestrator.view.drawing.mark import about_slot, slot_label
from bt_orchestrator.view.drawing.page import FlagLine, PageLayout
from bt_orchestrator.view.drawing.picture import LinePicture
from bt_orchestrator.view.drawing.plan import Column, Loop, Placed
from bt_orchestrator.view.drawing.svg_canvas import SvgCanvas
from bt_orchestrator.view.drawing.wording import ENGLISH, Wording

IDLE_COLUMNS = 20

INITIALIZATION = 'a section begins the first item of an order when its components are initialized'
BELT_MOVES = 'moves every item by one slot, when every section has let it go'
GROUP = 'these start together; the group ends when all of them ended'
LOOP = 'tasks that are all done again where a verdict refuses the result of one'
FLAG_IS = 'flag {flag}: capacity {capacity}, initial count {initial}'
FLAG_SET = '{task} starts while it is below {capacity}, and adds one after it'
FLAG_TAKEN = '{task} starts while it is above 0, and takes one after it'


def draw_line(
    script: Script,
    cell: Cell,
    state: LineState | None = None,
    wording: Wording = ENGLISH,
    *,
    is_bare: bool = False,
) -> LinePicture:
    """Draw a script as a process.

    :param state: the line at work, in the same words; None: the script alone
    :param is_bare: without title and legend
    """
    told_pace = pace(script, cell) if state is None else None
    sheet = Sheet(script, cell, state, told_pace, wording, is_bare)
    page = PageLayout(sheet, title(sheet).height, legend(sheet).height)
    size, about = (
        Box(0, 0, page.width, page.height),
        wording.say('script {name}', name=script.name),
    )
    canvas = SvgCanvas(size, about)
    _Drawing(sheet, page, canvas).whole()
    return LinePicture(str(canvas))


class _Drawing:
    """Puts the parts of a page on a canvas."""

    def __init__(self, sheet: Sheet, page: PageLayout, canvas: SvgCanvas) -> None:
        self._sheet = sheet
        self._page = page
        self._canvas = canvas
        self._say = sheet.wording.say
        self._names: dict[Box, str] = {}
        """Nodes by their place."""

    def whole(self) -> None:
        """Draw everything."""
        canvas, page = self._canvas, self._page
        if not self._sheet.is_bare:
            canvas.label('title', title(self._sheet), page.title, ['title'])
            canvas.label('legend', legend(self._sheet), page.legend, ['legend'])
        self.header()
        for column in page.columns:
            self.section(column)
        self.belts()
        self.flags()

    def header(self) -> None:
        """Draw the initialization and the belt's move."""
        page = self._page
        if page.initialization_frame is not None:
            words = self._say('Initialization, per order')
            box = page.initialization_frame
            self._frame('initialization', words, box, [self._say(INITIALIZATION)])
            self._cards(page.initialization)
        boxes = {placed.task.id: placed.box for placed in page.initialization}
        for dependency in self._sheet.script.initialization_dependencies:
            self._arrow(boxes[dependency.upstream], boxes[dependency.downstream])
        words = self._say('Belt, after every beat')
        self._frame('belt', words, page.belt_frame, [self._say(BELT_MOVES)])
        self._cards([page.move])

    def section(self, column: Column) -> None:
        """Draw one section."""
        number = column.number
        name = f'section.{number}'
        box = self._page.frame(column)
        self._frame(name, self._heading(number), box, self._about(number))
        for count, group in enumerate(column.groups, 1):
            self._group(f'{name}.group.{count}', group)
        for loop in column.loops:
            self._loop(f'repeat.{loop.repeat.name}', loop)
        self._slot(column)
        if column.release is not None:
            self._release(f'{name}.release', column.release)
        for count, join in enumerate(column.joins, 1):
            self._join(f'{name}.join.{count}', join)
        self._cards(column.cards)
        if not column.cards:
            self._idle(name, column.slot)
        for loop in column.loops:
            self._back(f'repeat.{loop.repeat.name}.back', loop)
        for start, other in column.arrows:
            self._arrow(start, other)

    def belts(self) -> None:
        """Draw the belt from slot to slot."""
        for number, points in self._page.belts():
            self._canvas.line(
                (f'slot.{number}', f'slot.{number + 1}'),
                points,
                self._belt_stroke(),
                name=f'belt.{number}',
                about=[
                    self._say(
                        'the belt, from section {number} to section {next}',
                        number=number,
                        next=number + 1,
                    )
                ],
            )

    def flags(self) -> None:
        """Draw the flags from task to task."""
        for flag in self._page.flags():
            self._flag(flag)

    def _belt_stroke(self) -> Stroke:
        state = self._sheet.state
        if state is None or not state.belt_moves:
            return Stroke(BELT, 5.0)
        return Stroke(INK, 5.0, dashed=True)

    # --- parts ------------------------------------------------------------------------------

    def _heading(self, number: int) -> str:
        script = self._sheet.script
        roles = [(self._say('source'), script.source), (self._say('sink'), script.sink)]
        name = self._say('Section {number}', number=number)
        return ' \u00b7 '.join([name, *(r for r, at in roles if at == number)])

    def _about(self, number: int) -> Sequence[str]:
        components = self._sheet.cell.components.values()
        here = ', '.join(
            component.name for component in components if number in component.sections
        )
        names = here or self._say('none')
        return [self._heading(number), self._say('components: {names}', names=names)]

    def _frame(self, name: str, words: str, box: Box, about: Sequence[str]) -> None:
        heading = one_entry(Text(words, 13, bold=True), width=box.width - 12)
        self._canvas.frame(name, heading, box, SECTION_FILL, about)

    def _group(self, name: str, box: Box) -> None:
        heading = one_entry(Text(self._say('in parallel'), italic=True), width=box.width - 12)
        self._canvas.frame(name, heading, box, GROUP_FILL, [self._say(GROUP)])

    def _loop(self, name: str, loop: Loop) -> None:
        self._names[loop.box] = f'task.{loop.repeat.tasks[0]}'
        words = f'\u21bb {rounds_words(loop.repeat, self._sheet.wording)}'
        heading = one_entry(Text(words, bold=True), width=loop.box.width - 12)
        self._canvas.frame(name, heading, loop.box, ROUND_FILL, [self._say(LOOP)])
        self._canvas.label(f'{name}.after', loop.after, loop.after_box, [self._say(LOOP)])

    def _back(self, name: str, loop: Loop) -> None:
        ends = self._names[loop.last], self._names[loop.first]
        self._canvas.line(
            ends, loop.way_back, Stroke(LOOP_LINE, 1.6), name=name, about=[self._say(LOOP)]
        )

    def _cards(self, cards: Iterable[Placed]) -> None:
        for card in cards:
            name = self._names[card.box] = f'task.{card.task.id}'
            about = details(self._sheet, card.task, card.belt)
            self._canvas.label(name, card.card, card.box, about)

    def _slot(self, column: Column) -> None:
        words = self._say('slot {number}', number=column.number)
        name = self._names[column.slot] = f'slot.{column.number}'
        label = _bar(words, INK, SLOT_FILL, column.slot)
        about = [self._say('{slot} of the belt', slot=words)]
        if self._sheet.state is not None:
            mark = self._sheet.state.sections.get(column.number, SectionMark())
            size, wording = (column.slot.width, column.slot.height), self._sheet.wording
            label = slot_label(column.number, mark, *size, wording)
            about += about_slot(mark, wording)
        self._canvas.label(name, label, column.slot, about)

    def _release(self, name: str, box: Box) -> None:
        self._names[box] = name
        about = self._say('from here on the belt may move; what is below runs meanwhile')
        label = _bar(self._say('belt released'), PAPER, BAR_FILL, box)
        self._canvas.label(name, label, box, [about])

    def _join(self, name: str, box: Box) -> None:
        self._names[box] = name
        self._canvas.point(name, box, [self._say(GROUP)])

    def _idle(self, section: str, slot: Box) -> None:
        words = wrapped(self._say('no task: items pass'), IDLE_COLUMNS)
        label = one_entry(*(Text(line, colour=FAINT, italic=True) for line in words))
        below = slot.moved(0, slot.height + 4 + (len(words) - 1) * LINE_HEIGHT * 5)
        about = self._say('the script has no list for this section')
        self._canvas.label(f'{section}.idle', label, below, [about])

    def _arrow(self, above: Box, below: Box) -> None:
        points = [(above.middle, above.bottom), (below.middle, below.top)]
        ends = self._names[above], self._names[below]
        self._canvas.line(ends, points, Stroke(head=below.height > 0))

    def _flag(self, line: FlagLine) -> None:
        flag = line.flag
        name = Text(self._say('flag {name}', name=flag.flag), colour=FLAG, bold=True)
        label = one_entry(name, Text(self._counts(flag), 9, FLAG))
        self._canvas.line(
            (f'task.{flag.upstream}', f'task.{flag.downstream}'),
            line.points,
            Stroke(FLAG, 1.6, dashed=True),
            name=f'flag.{flag.flag}',
            about=self._about_flag(flag),
            label=LineLabel(label, line.label_at),
        )

    def _counts(self, flag: Dependency) -> str:
        state = self._sheet.state
        if state is None or flag.flag not in state.flags:
            return self._say(
                'capacity {capacity}, initial {initial}',
                capacity=flag.capacity,
                initial=flag.initial,
            )
        count = state.flags[flag.flag]
        return self._say('count {count} of {capacity}', count=count, capacity=flag.capacity)

    def _about_flag(self, flag: Dependency) -> list[str]:
        say = self._say
        return [
            say(FLAG_IS, flag=flag.flag, capacity=flag.capacity, initial=flag.initial),
            say(FLAG_SET, task=flag.upstream, capacity=flag.capacity),
            say(FLAG_TAKEN, task=flag.downstream),
        ]


def _bar(words: str, colour: str, fill: str, box: Box) -> Label:
    text = Text(words, colour=colour, bold=True)
    return Label(((Entry((text,), centred=True, width=box.width, height=box.height),),), fill=fill)
