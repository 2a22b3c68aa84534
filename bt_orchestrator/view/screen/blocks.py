"""The parts of the picture of a cell, each as lines of one width."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from textwrap import wrap

from rich.text import Text

from bt_orchestrator.model.branch import Branch, Outcome
from bt_orchestrator.view.screen import words
from bt_orchestrator.view.screen.fit import Glyphs, LinePart, end_of, line, stay, widest
from bt_orchestrator.view.screen.plain import Twig, twigs
from bt_orchestrator.view.screen.view import CellView, HoldRow, JobRow, Row, Slot, Weight

NARROW = 60
"""Below this width, times and pictures make room for words."""

ELAPSED_WIDTH = 7

GOOD, CARE, BAD, QUIET = 'green', 'yellow', 'bold red', 'dim'

STATE_STYLES = {'Execute': GOOD, 'Held': BAD, 'Holding': BAD, 'Aborted': BAD, 'Aborting': BAD}
STATUS_STYLES = {
    Outcome.RUNNING: CARE,
    Outcome.SUCCESS: GOOD,
    Outcome.FAILURE: BAD,
    Outcome.INVALID: QUIET,
}


@dataclass(frozen=True)
class Block:
    """A part of the picture that can do with fewer lines than it has."""

    title: str
    draw: Callable[[int], list[Text]]
    """Returns at most so many lines."""
    wanted: int
    least: int = field(default=1)


def of_lines(
    title: str,
    lines: Sequence[Text],
    weights: Sequence[int],
    noun: str,
    least: int = 2,
    *,
    unlisted: int = 0,
) -> Block:
    """Return a block whose lines of little weight go first.

    :param unlisted: how many things there are that have no line
    """

    def draw(room: int) -> list[Text]:
        places = stay(weights, room)
        shown = [lines[place] for place in places]
        hidden = len(lines) - len(shown) + unlisted
        return shown + more(hidden, noun)[: room - len(shown)]

    return Block(title, draw, len(lines) + bool(unlisted), least)


def more(hidden: int, noun: str) -> list[Text]:
    """Return the line that says what is not shown, if there is any."""
    return [Text(f'… {hidden} more {noun}', style=QUIET)] if hidden else []


# --- the head ---------------------------------------------------------------------------------


def head(view: CellView, node: str, width: int, glyphs: Glyphs) -> list[Text]:
    """Return what is always there: the cell, its state, its belt."""
    name = Text(view.cell, style='bold')
    sign = glyphs.held if view.is_held else glyphs.working if _runs(view) else glyphs.waiting
    style = BAD if view.is_held else STATE_STYLES.get(view.state, CARE)
    name.append(f'  {sign} {view.state}', style=style)
    clock = time.strftime('%H:%M:%S', time.localtime(view.made_at))
    first = [LinePart(name, None)]
    if width >= NARROW:
        right = f'{node}  {clock}'
        first.append(LinePart(Text(right, style=QUIET), widest([right], width // 2)))
    return [line(first, width), belt(view, width, glyphs)]


def _runs(view: CellView) -> bool:
    return view.state == 'Execute'


def belt(view: CellView, width: int, glyphs: Glyphs) -> Text:
    """Return the belt in its direction of travel, with as much of the items as fits."""
    arrow = glyphs.move if 'moving' in view.belt else glyphs.rest
    label = f'belt {view.belt:<7}  '
    strips = [
        f'{label}{_strip(view.slots, glyphs, named, blank)} {arrow}'
        for named, blank in ((str, ' '), (_number_of, ' '), (_number_of, ''), (_unnamed, ''))
    ]
    fitting = (strip for strip in strips if widest([strip], width + 1) <= width)
    return line([LinePart(Text(next(fitting, strips[-1])), None)], width)


def _strip(slots: Sequence[Slot], glyphs: Glyphs, named: Callable[[str], str], blank: str) -> str:
    texts = [_carried(slot, glyphs, named(slot.name)) for slot in slots]
    wall = f'{blank}{glyphs.wall}{blank}'
    return f'{glyphs.wall}{blank}{wall.join(texts)}{blank}{glyphs.wall}'


def _carried(slot: Slot, glyphs: Glyphs, name: str) -> str:
    """Return an item with the signs of what is wrong with it, which stand where no name does."""
    if not slot.name:
        return glyphs.empty
    signs = glyphs.rejected if slot.is_rejected else ''
    signs += glyphs.nonconforming if slot.is_nonconforming else ''
    return f'{name}{signs}' or glyphs.packed


def _unnamed(_: str) -> str:
    return ''


def _number_of(slot: str) -> str:
    """Return the number of an item, in brackets if it is not there."""
    number = slot.strip('()').rpartition('/')[2]
    return f'({number})' if slot.startswith('(') else number


# --- what has to be done ----------------------------------------------------------------------


def holds(rows: Sequence[HoldRow], width: int, glyphs: Glyphs) -> Block:
    """Return the holds; what is held stays longest, then what to type. Nothing of it is cut."""
    lines: list[Text] = []
    weights: list[int] = []
    for row in rows:
        texts = [f'{glyphs.held} {row.text}', *(f'  {advice}' for advice in row.advice)]
        for weight, text in enumerate(texts):
            style = BAD if weight == 0 else ''
            wrapped = wrap(
                text, max(width, 20), subsequent_indent='      ', break_on_hyphens=False
            )
            lines += [_cut(Text(part, style=style), width) for part in wrapped]
            weights += [weight] * len(wrapped)
    return of_lines('holds', lines, weights, 'lines about holds', least=min(len(lines), 6))


def next_lines(texts: Sequence[str], width: int) -> Block:
    """Return what can be typed next; nothing of it is cut."""
    wrapped = [
        _cut(Text(part), width)
        for text in texts
        for part in wrap(text, max(width, 20), subsequent_indent='      ', break_on_hyphens=False)
    ]
    return of_lines('next', wrapped, [0] * len(wrapped), 'lines', least=len(wrapped))


def troubles(view: CellView, width: int, glyphs: Glyphs) -> Block:
    """Return the components that can be sent nothing."""
    lines = [_cut(Text(f'{glyphs.held} {text}', style=CARE), width) for text in view.troubles]
    return of_lines('', lines, [0] * len(lines), 'components')


def _cut(text: Text, width: int) -> Text:
    return line([LinePart(text, None)], width)


# --- what goes on -----------------------------------------------------------------------------


def jobs(rows: Sequence[JobRow], width: int, glyphs: Glyphs, unlisted: int = 0) -> Block:
    """Return a line for each job; running ones stay longest.

    :param unlisted: how many there are besides
    """
    names = widest([row.id for row in rows], max(width // 5, 6))
    scripts = widest([row.script for row in rows], width // 4)
    states = widest([row.state for row in rows], 17)
    bar_width = max(width // 8, 8)
    lines = []
    for row in rows:
        cells = [LinePart(Text(end_of(row.id, names), style='bold'), names)]
        if width >= NARROW:
            cells.append(LinePart(Text(row.script), scripts))
        cells.append(LinePart(Text(row.state, style=_job_style(row)), states))
        if width >= NARROW + bar_width:
            cells.append(LinePart(bar(row, bar_width, glyphs), bar_width))
        lines.append(line([*cells, LinePart(Text(row.counts), None)], width))
    return of_lines('jobs', lines, [row.weight for row in rows], 'jobs', unlisted=unlisted)


def _job_style(row: JobRow) -> str:
    return {'Running': GOOD, 'Interrupted': BAD, 'Aborted': BAD}.get(row.state, '')


def bar(row: JobRow, width: int, glyphs: Glyphs) -> Text:
    """Return a job's progress: what has left the line, what is on it, what is to come."""
    out = int(row.packed * width)
    there = min(round((row.packed + row.on_line) * width), width) - out
    text = Text(glyphs.packed * out, style=GOOD)
    text.append(glyphs.on_line * there, style=CARE)
    return text.append(glyphs.to_come * (width - out - there), style=QUIET)


def sections(view: CellView, age_s: float, width: int, glyphs: Glyphs) -> Block:
    """Return what every section does or waits for; the held and the working stay longest."""
    slot_width = max(widest([slot.name for slot in view.slots], max(width // 5, 5)), 1)
    lines, weights = [], []
    before = 0
    for row in view.rows:
        lines.append(_section(row, age_s, width, slot_width, glyphs, first=row.section != before))
        weights.append(row.weight)
        before = row.section
    for text in view.initialization:
        lines.append(_cut(Text(f'initialization  {text}'), width))
        weights.append(Weight.WAITING_WITH_ITEM)
    for text in view.belt_waiting:
        lines.append(_cut(Text(f'belt  {text}', style=QUIET), width))
        weights.append(Weight.ENDED)
    return of_lines('sections', lines, weights, 'lines about sections', least=4)


def _section(
    row: Row, age_s: float, width: int, slot_width: int, glyphs: Glyphs, *, first: bool
) -> Text:
    number = f'{row.section:>3}' if first else '   '
    style = {Weight.HELD: BAD, Weight.WORKING: GOOD}.get(row.weight, QUIET)
    slot = Text(end_of(row.slot, slot_width) if first else '', style='bold')
    cells = [
        LinePart(Text(number), 3),
        LinePart(slot, slot_width),
        LinePart(Text(glyphs.of_row(row.weight), style=style), 1),
        LinePart(
            Text(row.text, style='' if row.weight < Weight.WAITING_WITH_ITEM else QUIET), None
        ),
    ]
    if width >= NARROW and row.elapsed_s is not None:
        elapsed = words.duration(row.elapsed_s + age_s)
        cells.append(LinePart(Text(f'{elapsed:>{ELAPSED_WIDTH}}'), ELAPSED_WIDTH))
    return line(cells, width)


def flags(view: CellView, width: int) -> Block:
    """Return all flags in one line."""
    text = ', '.join(view.flags)
    return of_lines('', [_cut(Text(f'flags  {text}', style=QUIET), width)], [0], 'flags', least=1)


# --- inside the node --------------------------------------------------------------------------


def tree(root: Branch, width: int, glyphs: Glyphs) -> Block:
    """Return the behaviour tree, folded as far as needed."""

    def draw(room: int) -> list[Text]:
        shown, hidden = twigs(root, room)
        lines = [_twig(twig, width, glyphs) for twig in shown]
        return lines + more(hidden, 'behaviours')[: room - len(lines)]

    return Block('tree', draw, len(twigs(root, 100_000)[0]), least=5)


def _twig(twig: Twig, width: int, glyphs: Glyphs) -> Text:
    branch = twig.branch
    style = STATUS_STYLES[branch.status]
    # A deep tree on a narrow terminal keeps half of it for names.
    text = Text(' ' * min(2 * twig.depth, width // 2))
    text.append(f'{glyphs.of_status(branch.status)} ', style=style).append(branch.name)
    text.append(f'  {branch.status.word}', style=style)
    return _cut(text.append(f'  {branch.words}', style=QUIET), width)


def blackboard(values: Mapping[str, str], width: int) -> Block:
    """Return the variables of the blackboard."""
    names = widest(list(values), width // 2)
    lines = [
        line([LinePart(Text(end_of(key, names)), names), LinePart(Text(value), None)], width)
        for key, value in values.items()
    ]
    return of_lines('blackboard', lines, [0] * len(lines), 'variables', least=3)
