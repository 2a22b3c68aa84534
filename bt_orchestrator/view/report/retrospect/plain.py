"""A job beside its forecast, as plain data."""

from __future__ import annotations

from typing import Any

from bt_orchestrator.view.report.account.plain import held_plain, seconds_of, summed
from bt_orchestrator.view.report.retrospect.course import Course, Work
from bt_orchestrator.view.report.retrospect.retrospect import Deviation, Pair, Retrospect
from bt_orchestrator.view.report.retrospect.text import notes, period_of, words_of


def retrospect_plain(found: Retrospect) -> dict[str, Any]:
    """Return everything; times in seconds, null: not known."""
    times = found.real.times
    return {
        'job': found.job,
        'cell': times.cell or None,
        'started': period_of(found).iso(found.begin_us),
        'first_seq': found.first_seq,
        'durations': 'usual' if found.usual else 'cell file',
        'notes': list(notes(found)),
        'forecast': _course(found, found.forecast),
        'real': _course(found, found.real),
        'late_s': seconds_of(found.late_us),
        'items': [pair._asdict() for pair in found.items()],
        'time': [_timed(pair) for pair in (*found.times(), found.total)],
        'components': [_timed(pair) for pair in found.busy()],
        'tasks': [
            {
                'component': one.component,
                'task': one.name,
                'times': one.times,
                'forecast_s': seconds_of(one.forecast_us),
                'real_s': seconds_of(one.real_us),
            }
            for one in found.tasks()
        ],
        'first_deviation': _deviation(found, found.first_deviation()),
        'worst_deviation': _deviation(found, found.worst_deviation()),
        'stops': [{**summed(one), 'loss': one.loss.value} for one in times.stops],
        'holds': [held_plain(held, period_of(found)) for held in times.holds],
        'failed_attempts': [summed(one) for one in times.failing],
    }


def _course(found: Retrospect, course: Course) -> dict[str, Any]:
    when = period_of(found).iso
    return {
        'end': None if course.end_us is None else when(course.end_us),
        'compared_to': when(course.until_us),
    }


def _timed(pair: Pair) -> dict[str, Any]:
    seconds = seconds_of(pair.forecast), seconds_of(pair.real)
    return {'what': pair.what, 'forecast_s': seconds[0], 'real_s': seconds[1]}


def _deviation(found: Retrospect, one: Deviation | None) -> dict[str, Any] | None:
    if one is None:
        return None
    task = one.real.key.task
    return {
        'words': words_of(one),
        'section': task.section,
        'item': task.item,
        'task': task.task,
        'name': one.real.name,
        'component': one.real.component,
        'round': one.real.key.round,
        'attempt': one.real.key.attempt,
        'reason': one.real.reason or None,
        'late_s': seconds_of(one.late_us),
        'forecast': None if one.forecast is None else _work(found, one.forecast),
        'real': _work(found, one.real),
    }


def _work(found: Retrospect, work: Work) -> dict[str, Any]:
    when = period_of(found).iso
    return {'from': when(work.start_us), 'to': when(work.end_us)}
