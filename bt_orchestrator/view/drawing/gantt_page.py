"""The layout of a Gantt chart, as SVG: time to the right, one row a part of the cell.

In a row of a section the items are above the tasks, for as long as the section works on them;
tasks that run at the same time are in lanes. A forecast is lighter, and above what it was of.
Everything has a tooltip.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from datetime import datetime
from typing import Any

from bt_orchestrator.view.drawing.canvas import Box
from bt_orchestrator.view.drawing.gantt import CycleBar, End, Gantt, HoldBar, Row, TaskBar
from bt_orchestrator.view.drawing.gantt_style import (
    JOB_COLOURS,
    JOB_LINES,
    SIZES,
    add_legend,
    add_style,
    add_text,
    fill_of_wait,
    fitting,
)
from bt_orchestrator.view.drawing.label import PAPER
from bt_orchestrator.view.drawing.svg import CHARACTER, Svg
from bt_orchestrator.view.report.wait_log import WaitSpan, cause_words

LEFT, RIGHT, TOP = 118.0, 24.0, 66.0
STRIP, LANE, GAP = 15.0, 18.0, 9.0
"""Heights of a row's items, of a lane of tasks, and of the space to the next row."""

LEGEND_HEIGHT = 72.0
ITEM_ROOM = 110.0
"""Pixels for the time of one item, as far as the widest page allows."""

WIDTHS = (1200.0, 12000.0)
"""Narrowest and widest plot."""


def gantt_svg(gantt: Gantt, narrowest: float = WIDTHS[0]) -> str:
    """Draw a chart; the same chart gives the same text.

    :param narrowest: the least width of its plot, in pixels
    """
    return str(_Page(gantt, narrowest).drawn())


class _Page:
    def __init__(self, gantt: Gantt, narrowest: float) -> None:
        self._gantt = gantt
        self._total_s = gantt.total_s or 1.0
        self._left = _room_of_titles(gantt)
        self._plot = max(narrowest, min(WIDTHS[1], ITEM_ROOM * gantt.items))
        heights = [_height(row) for row in gantt.rows]
        self._tops = [*itertools.accumulate(heights, initial=TOP)]
        self._bottom = self._tops[-1]
        height = self._bottom + 26.0 + LEGEND_HEIGHT
        self._size = (self._left + self._plot + RIGHT, height)
        self._svg = Svg.page(Box(0.0, 0.0, *self._size), f'Gantt chart of cell {gantt.cell}')
        self._letters = _letters(gantt.jobs)

    def drawn(self) -> Svg:
        add_style(self._svg)
        width, _ = self._size
        add_text(self._svg, 12.0, 24.0, self._headline(), 'title')
        for number, (row, top) in enumerate(zip(self._gantt.rows, self._tops, strict=False)):
            if number % 2 == 0:
                band = _height(row)
                self._svg.add('rect', x=0, y=top, width=width, height=band, class_='band')
        self._axis()
        for row, top in zip(self._gantt.rows, self._tops, strict=False):
            self._row(row, top)
        for end in self._gantt.ends:
            self._end(end)
        add_legend(self._svg, self._gantt, self._letters, (12.0, self._bottom + 40.0), width)
        return self._svg

    def _headline(self) -> str:
        if self._gantt.title:
            return self._gantt.title
        jobs = ', '.join(self._gantt.jobs)
        return f'cell {self._gantt.cell}: {jobs}; {self._gantt.total_s:g} s in virtual time'

    def _x(self, time_s: float) -> float:
        share = (time_s - self._gantt.begin_s) / self._total_s
        return self._left + max(0.0, min(1.0, share)) * self._plot

    def _axis(self) -> None:
        for mark, label in marks(self._gantt, self._plot):
            x = self._x(mark)
            self._svg.add('line', x1=x, y1=TOP - 6, x2=x, y2=self._bottom, class_='grid')
            for y in (TOP - 11.0, self._bottom + 14.0):
                add_text(self._svg, x, y, label, 'tick')

    def _when(self, bar: TaskBar | CycleBar | HoldBar | WaitSpan) -> str:
        return span_words(self._gantt, bar.start_s, bar.end_s)

    # --- rows -------------------------------------------------------------------------------

    def _row(self, row: Row, top: float) -> None:
        group = self._svg.add('g', id=row.title.replace(' ', '_'))
        lanes = row.lanes()
        first = top + GAP / 2 + _strip(row)
        add_text(group, 12.0, top + _height(row) / 2 + 4.0, row.title, 'row')
        for wait in row.waits:
            self._wait(group, wait, first)
        for cycle in row.cycles:
            self._cycle(group, cycle, first - STRIP)
        for bar in row.forecast:
            self._forecast(group, bar, first - STRIP)
        for hold in row.holds:
            self._hold(group, hold, first)
        for number, lane in enumerate(lanes):
            for bar in lane:
                self._task(group, bar, first + number * LANE)

    def _bar(self, group: Svg, start_s: float, end_s: float, y: float, **more: Any) -> Svg:
        x = self._x(start_s)
        width = max(0.5, self._x(end_s) - x)
        return group.add('rect', x=x, y=y, width=width, **more)

    def _wait(self, group: Svg, wait: WaitSpan, y: float) -> None:
        fill = fill_of_wait(wait.causes[0].kind)
        bar = self._bar(
            group, wait.start_s, wait.end_s, y + 4, height=LANE - 8, fill=fill, class_='wait'
        )
        bar.add('title', f'waits for {cause_words(wait.causes)}\n{self._when(wait)}')

    def _cycle(self, group: Svg, cycle: CycleBar, y: float) -> None:
        colour = self._colour(cycle.job)
        style = {'fill': PAPER, 'stroke': JOB_LINES[colour], 'class_': 'cycle'}
        bar = self._bar(group, cycle.start_s, cycle.end_s, y, height=STRIP - 2, rx=3, **style)
        bar.add('title', f'{cycle.item}\n{self._when(cycle)}')
        room = self._x(cycle.end_s) - self._x(cycle.start_s) - 4
        number = cycle.item.rpartition('/')[2]
        for text in (cycle.item, self._short(cycle.job, number), number):
            if add_text(group, self._x(cycle.start_s) + 3, y + 10, text, 'item', room):
                return

    def _hold(self, group: Svg, hold: HoldBar, y: float) -> None:
        bar = self._bar(group, hold.start_s, hold.end_s, y + 1, height=LANE - 2, class_='hold')
        bar.add('title', f'hold {hold.hold}: {hold.words}\n{self._when(hold)}')
        room = self._x(hold.end_s) - self._x(hold.start_s) - 4
        add_text(group, self._x(hold.start_s) + 3, y + 12, f'HOLD {hold.hold}', 'task', room)

    def _forecast(self, group: Svg, bar: TaskBar, y: float) -> None:
        look = self._look(bar)
        look['class_'] += ' forecast'
        drawn = self._bar(group, bar.start_s, bar.end_s, y + 2, height=STRIP - 2, **look)
        drawn.add('title', f'forecast: {self._what(bar)}\n{self._when(bar)}')
        self._label(group, bar, y + 12)

    def _task(self, group: Svg, bar: TaskBar, y: float) -> None:
        drawn = self._bar(group, bar.start_s, bar.end_s, y + 1, height=LANE - 2, **self._look(bar))
        end = '' if bar.outcome == 'succeeded' else f'\n{bar.outcome}'
        drawn.add('title', f'{self._what(bar)}\n{self._when(bar)}{end}')
        if bar.failed:
            group.add('path', d=self._cross(bar, y), class_='cross')
        self._label(group, bar, y + 12)

    def _end(self, end: End) -> None:
        x, kind = self._x(end.time_s), 'forecast_end' if end.is_forecast else 'end'
        y = TOP - 26.0 if end.is_forecast else self._bottom + 27.0
        ends = (y + 3, self._bottom) if end.is_forecast else (TOP - 6, y - 10)
        self._svg.add('line', x1=x, y1=ends[0], x2=x, y2=ends[1], class_=kind)
        words = 'forecast end' if end.is_forecast else 'end'
        add_text(self._svg, x, y, words, 'ends')

    def _label(self, group: Svg, bar: TaskBar, y: float) -> None:
        room = self._x(bar.end_s) - self._x(bar.start_s) - 4
        text = fitting(self._text(bar), 'task', room)
        add_text(group, self._x(bar.start_s) + 3, y, text, 'task')

    def _what(self, bar: TaskBar) -> str:
        again = f', {bar.again}' if bar.again else ''
        return f'{bar.key}: {bar.name} at {bar.component}{again}'

    def _text(self, bar: TaskBar) -> str:
        """Return what stands on a bar; the row of a section names its items above."""
        if bar.key.job is None:
            return ''
        if not bar.key.item:
            return self._short(bar.key.job, bar.key.task)
        if not self._gantt.by_component:
            return bar.key.task
        number = bar.key.item.rpartition('/')[2]
        return f'{self._short(bar.key.job, number)}: {bar.key.task}'

    def _short(self, job: str, what: str) -> str:
        letter = self._letters[job]
        return f'{letter}.{what}' if letter else what

    def _look(self, bar: TaskBar) -> dict[str, str]:
        if bar.key.job is None:
            return {'class_': 'move failed' if bar.failed else 'move'}
        colour = self._colour(bar.key.job)
        look = {'fill': JOB_COLOURS[colour], 'stroke': JOB_LINES[colour]}
        return {**look, 'class_': 'work failed' if bar.failed else 'work'}

    def _cross(self, bar: TaskBar, y: float) -> str:
        x, size = self._x(bar.end_s) - 7, 5
        return f'M{x:.2f} {y + 6:.2f} l{size} {size} m0 -{size} l-{size} {size}'

    def _colour(self, job: str) -> int:
        return self._gantt.jobs.index(job) % len(JOB_COLOURS)


def _height(row: Row) -> float:
    return GAP + _strip(row) + LANE * len(row.lanes())


def _strip(row: Row) -> float:
    """Return the height of what stands above the tasks."""
    return STRIP if row.cycles or row.forecast else 0.0


def _room_of_titles(gantt: Gantt) -> float:
    longest = max((len(row.title) for row in gantt.rows), default=0)
    return max(LEFT, 13.0 + longest * SIZES['row'] * CHARACTER)


def _letters(jobs: tuple[str, ...]) -> dict[str, str]:
    """Give each job a short name, where there is more than one."""
    if len(jobs) < 2:
        return dict.fromkeys(jobs, '')
    return dict(zip(jobs, _short_names(), strict=False))


def _short_names() -> Iterator[str]:
    """Yield A, B, … Z, A2, B2 and so on."""
    for turn in itertools.count(1):
        for letter in 'ABCDEFGHIJKLMNOPQRSTUVWXYZ':
            yield f'{letter}{"" if turn == 1 else turn}'


# The time axis of a Gantt chart.

TICK_ROOM = 64.0
"""Least pixels between two ticks."""

_STEPS_S = (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200, 1800, 3600, 7200, 14400)


def marks(gantt: Gantt, room_px: float) -> Iterator[tuple[float, str]]:
    """Yield the times to mark in a plot of a width, and what is written there."""
    if gantt.is_past:
        yield from _past_marks(gantt, room_px)
        return
    times = ticks(gantt.total_s or 1.0, room_px)
    step_s = times[1] if len(times) > 1 else gantt.total_s or 1.0
    yield from ((time, time_label(time, step_s)) for time in times)


def span_words(gantt: Gantt, start_s: float, end_s: float) -> str:
    """Say from when to when something was, and how long."""
    if not gantt.is_past:
        return f'{start_s:g} to {end_s:g} s, {end_s - start_s:g} s'
    begin, end = (datetime.fromtimestamp(s).strftime('%H:%M:%S.%f')[:-4] for s in (start_s, end_s))
    return f'{begin} to {end}, {end_s - start_s:.2f} s'


def ticks(total_s: float, room_px: float) -> tuple[float, ...]:
    """Return the times to mark, at round distances, in a plot of a width."""
    step_s = _step_s(total_s, room_px)
    return tuple(step_s * n for n in range(int(total_s / step_s + 1e-9) + 1))


def time_label(time_s: float, step_s: float) -> str:
    """Write a time as the axis does: seconds, or hours, minutes and seconds."""
    if step_s < 60:
        return f'{time_s:g} s'
    minutes, seconds = divmod(round(time_s), 60)
    hours, minutes = divmod(minutes, 60)
    return f'{hours}:{minutes:02}:{seconds:02}' if hours else f'{minutes}:{seconds:02}'


def _step_s(total_s: float, room_px: float) -> float:
    least_s = total_s * TICK_ROOM / room_px
    return next((s for s in _STEPS_S if s >= least_s), None) or -(-least_s // 86400) * 86400


def _past_marks(gantt: Gantt, room_px: float) -> Iterator[tuple[float, str]]:
    """Yield round times of the clock on the wall."""
    begin = datetime.fromtimestamp(gantt.begin_s)
    midnight = begin.replace(hour=0, minute=0, second=0, microsecond=0).timestamp()
    step_s = _step_s(gantt.total_s or 1.0, room_px)
    number = -(-(gantt.begin_s - midnight) // step_s)
    form = '%H:%M' if step_s >= 60 else '%H:%M:%S' if step_s >= 1 else '%H:%M:%S.%f'
    while (time := midnight + number * step_s) <= gantt.begin_s + gantt.total_s:
        text = datetime.fromtimestamp(time).strftime(form)
        yield time, text[:-5] if step_s < 1 else text
        number += 1
