"""The account of the shift that runs, on a terminal of any size."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

from rich.console import Console, ConsoleOptions, RenderResult
from rich.text import Text

from bt_orchestrator.view.report.account.figures import Bar, Figures
from bt_orchestrator.view.report.account.live import Live, cause_words, over_words
from bt_orchestrator.view.report.account.losses import WORDS, Step
from bt_orchestrator.view.report.account.words import duration, percent, rate
from bt_orchestrator.view.screen.blocks import BAD, CARE, NARROW, QUIET
from bt_orchestrator.view.screen.fit import ASCII, UNICODE, Glyphs, LinePart, line
from bt_orchestrator.view.screen.keys import SecondScreen

_TITLE, _TIME, _PART = 18, 9, 8
"""Widths of the columns of a loss."""


class ShiftScreen:
    """Draws the account on the terminal's second screen."""

    def __init__(self, screen: SecondScreen) -> None:
        self._screen = screen
        self._last: Live | None = None

    def show(self, live: Live | None, why_not: str) -> None:
        """Draw what there is; while the journal cannot be read, what was, and why."""
        self._last = live or self._last
        self._screen.show(ShiftPicture(self._last, why_not))


@dataclass(frozen=True)
class ShiftPicture:
    """The knowledge at one moment. Draws itself in the room that rich gives it."""

    live: Live | None
    """None: the journal has no event yet."""
    note: str = ''
    """Below all else: why it is not of now; empty: it is."""

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        glyphs = ASCII if options.ascii_only else UNICODE
        room = options.height or console.height
        for row in self.lines(options.max_width, room, glyphs):
            row.end = '\n'
            yield row

    def lines(self, width: int, room: int, glyphs: Glyphs = UNICODE) -> list[Text]:
        """Return the picture, no more lines than there is room for; losses go first."""
        feet = [Text(self.note, style='reverse bold')] if self.note else []
        if self.live is None:
            head, losses = [Text('the journal has no event yet')], []
        else:
            head = [*_head(self.live, width, glyphs)]
            losses = [*_losses(self.live.account.figures, width, glyphs)]
            feet = [*_notes(self.live), *feet]
        left = max(0, room - len(head) - len(feet))
        shown = [*head, *losses[: max(left, 0)], *feet][:room]
        for row in shown:
            row.truncate(width, overflow='ellipsis')
        return shown


def _head(live: Live, width: int, glyphs: Glyphs) -> Iterator[Text]:
    period, shown = live.account.period, live.account.figures
    name = Text(', '.join(filter(None, (shown.times.cell, period.name))), style='bold')
    until = period.clock(period.end_us)
    when = f'{period.clock(period.begin_us)} to {until}' if width >= NARROW else until
    yield line([LinePart(name, None), LinePart(Text(when, style=QUIET), len(when))], width)
    yield _state(live, glyphs)
    yield Text()
    yield line(
        [LinePart(Text(f'OEE {percent(shown.oee):>8}', style='bold'), 13),
         LinePart(_bar(shown.oee or Fraction(0), width - 14, glyphs), None)], width,
    )  # fmt: skip
    times = '\N{MULTIPLICATION SIGN}' if glyphs is UNICODE else 'x'
    yield Text(
        f'  = availability {percent(shown.availability)} {times} performance '
        f'{percent(shown.performance)} {times} quality {percent(shown.quality)}'
    )
    yield Text(f'made {shown.produced}, {shown.good} of them good')
    if shown.produced:
        yield Text(f'rate {rate(shown.per_item_us)}; the pace is {rate(shown.pace_us)}')


def _state(live: Live, glyphs: Glyphs) -> Text:
    """Say what goes on now."""
    if not live.runs:
        return Text(over_words(live), style=QUIET)
    stopped = live.stopped
    if stopped is None:
        return Text(f'{glyphs.working} produces')
    period = live.account.period
    took = duration(period.end_us - stopped.since_us)
    words = f'{cause_words(stopped.cause)} since {period.clock(stopped.since_us)}, {took}'
    is_loss = WORDS[stopped.cause.loss].step is not Step.NOT_BUSY
    return Text(
        f'{glyphs.held} {words}', style=(BAD if stopped.cause.hold else CARE) if is_loss else ''
    )


def _losses(shown: Figures, width: int, glyphs: Glyphs) -> Iterator[Text]:
    """Yield the losses, the largest first, with bars by the planned time that has passed."""
    whole = shown.times.planned.total_us
    bars = sorted((bar for bar in shown.steps_seen() if bar.loss), key=lambda bar: -bar.us)
    if not bars:
        return
    yield Text()
    yield Text('lost', style=QUIET)
    for bar in bars:
        yield _loss(bar, whole, width, glyphs)


def _loss(bar: Bar, whole: int, width: int, glyphs: Glyphs) -> Text:
    part = Fraction(bar.us) / whole
    room = width - _TITLE - _TIME - _PART - 3
    cells = [
        LinePart(Text(bar.title), _TITLE),
        LinePart(Text(f'{duration(bar.us):>{_TIME}}'), _TIME),
        LinePart(Text(f'{percent(part):>{_PART}}'), _PART),
    ]
    if room >= _PART:
        cells.append(LinePart(_bar(part, room, glyphs), None))
    return line(cells, width)


def _bar(part: Fraction, width: int, glyphs: Glyphs) -> Text:
    full = min(max(round(part * width), 0), max(width, 0))
    return Text(glyphs.packed * full).append(glyphs.to_come * (width - full), style=QUIET)


def _notes(live: Live) -> Iterator[Text]:
    notes = live.account.notes()[1:]
    if notes:
        yield Text()
    yield from (Text(note, style=QUIET) for note in notes)
