"""The time axis of a Gantt chart."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import datetime

from bt_orchestrator.view.drawing.gantt import Gantt

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
