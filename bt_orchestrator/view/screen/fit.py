"""The fit of texts into a terminal: their lines, their cells, and signs in Unicode or in ASCII."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from rich.cells import cell_len
from rich.text import Text

from bt_orchestrator.model.branch import Outcome
from bt_orchestrator.view.screen.view import Weight


class Glyphs(NamedTuple):
    """The signs and their places."""

    working: str
    waiting: str
    held: str
    packed: str
    on_line: str
    to_come: str
    wall: str
    empty: str
    rest: str
    move: str
    success: str
    failure: str
    rejected: str
    nonconforming: str
    ellipsis: str
    rule: str

    def of_row(self, weight: Weight) -> str:
        """Return the sign of a section's row."""
        signs = {Weight.HELD: self.held, Weight.WORKING: self.working}
        return signs.get(weight, self.waiting)

    def of_status(self, status: Outcome) -> str:
        """Return the sign of a behaviour's status."""
        return {
            Outcome.RUNNING: self.working,
            Outcome.SUCCESS: self.success,
            Outcome.FAILURE: self.failure,
            Outcome.INVALID: self.waiting,
        }[status]


UNICODE = Glyphs('▶', '·', '■', '█', '▒', '░', '│', '·', '→', '»', '✓', '✗', '✗', '≈', '…', '─')
ASCII = Glyphs('>', '.', '!', '#', '=', '-', '|', '.', '->', '>>', '+', 'x', 'x', '~', '.', '-')


ELLIPSIS = '…'


class LinePart(NamedTuple):
    """A part of a line."""

    text: Text
    width: int | None
    """None: whatever the others leave."""


def line(cells: Sequence[LinePart], width: int) -> Text:
    """Return one line of a width: cells with a blank between them."""
    fixed = sum(cell.width for cell in cells if cell.width is not None) + len(cells) - 1
    joined = Text(no_wrap=True)
    for number, cell in enumerate(cells):
        own = max(width - fixed, 0) if cell.width is None else cell.width
        text = cell.text.copy()
        text.truncate(own, overflow='ellipsis', pad=True)
        joined.append(' ' if number else '').append_text(text)
    joined.truncate(width, overflow='ellipsis')
    return joined


def end_of(text: str, width: int) -> str:
    """Return a text, or as much of its end as fits: the number of an item says more than its job.

    >>> end_of('WO-2026-11-21/7', 8)
    '…1-21/7'
    """
    if cell_len(text) <= width:
        return text
    while text and cell_len(text) + 1 > width:
        text = text[1:]
    return f'{ELLIPSIS}{text}'


def widest(texts: Sequence[str], most: int) -> int:
    """Return the width that the widest of some texts takes, and no more than `most`."""
    return min(max(map(cell_len, texts), default=0), most)


def heights(wanted: Sequence[int], least: Sequence[int], room: int) -> list[int]:
    """Return how many lines each part gets.

    First every part gets the least that it asks for, then, in order, what it wants; so the order
    of the parts is that of their importance.
    """
    given = []
    for want, small in zip(wanted, least, strict=True):
        given.append(min(want, small, room))
        room -= given[-1]
    for number, want in enumerate(wanted):
        more = min(want - given[number], room)
        given[number] += more
        room -= more
    return given


def stay(weights: Sequence[int], room: int) -> list[int]:
    """Return the places of the rows that stay, in their order: the lightest, the first of equals.

    Where some must go, one line of the room is left for the words about them.
    """
    if len(weights) <= room:
        return list(range(len(weights)))
    by_weight = sorted(range(len(weights)), key=lambda place: (weights[place], place))
    return sorted(by_weight[: max(room - 1, 0)])
