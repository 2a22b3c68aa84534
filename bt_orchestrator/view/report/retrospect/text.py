"""A job beside its forecast, as text for a terminal and as plain data."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from bt_orchestrator.model.hold_words import again_words
from bt_orchestrator.view.report.account.period import Period
from bt_orchestrator.view.report.account.plain import held_plain, seconds_of, stop_plain, summed
from bt_orchestrator.view.report.account.text import failing_lines, hold_lines, stop_lines, titled
from bt_orchestrator.view.report.account.words import UNKNOWN, duration, is_seen
from bt_orchestrator.view.report.retrospect.retrospect import (
    Course,
    Deviation,
    Pair,
    Retrospect,
    Work,
    title_of,
)
from bt_orchestrator.view.report.tables import table

MOST_TASKS = 10
"""Lines of tasks that took longer or shorter; JSON has all."""

_COLUMNS = ('forecast', 'real', 'difference')


def period_of(retrospect: Retrospect) -> Period:
    """Return the time of a job."""
    begin_us, until_us = retrospect.begin_us, retrospect.real.until_us
    return Period.all_planned(f'job {retrospect.job}', begin_us, until_us, retrospect.steady)


def retrospect_text(retrospect: Retrospect) -> Iterator[str]:
    """Yield the lines; each part is left out where it has nothing to say."""
    period, times = period_of(retrospect), retrospect.real.times
    cell = f'cell {times.cell}, ' if times.cell else ''
    started = period.when(retrospect.begin_us)
    yield f'{cell}job {retrospect.job}, started {started}: forecast and reality'
    yield from (f'  {note}' for note in notes(retrospect))
    yield ''
    yield from table(
        ('', *_COLUMNS), [*_ends(retrospect, period), *map(_counted, retrospect.items())]
    )
    yield from titled('where the time went', _where(retrospect))
    yield from titled('at work', _timed(retrospect.busy()))
    yield from titled('tasks that took longer or shorter', _tasks(retrospect))
    yield from _deviations(retrospect, period)
    yield from titled('stops, the longest first', stop_lines(times))
    yield from titled('holds', hold_lines(times, period))
    yield from titled('failed attempts', failing_lines(times))


def notes(retrospect: Retrospect) -> Iterator[str]:
    """Say what the forecast is, and what limits it."""
    durations = 'that tasks had taken before' if retrospect.usual else 'of the cell file'
    run = f'a virtual run from event {retrospect.first_seq} on'
    yield f'the forecast is {run}, with the durations {durations}'
    if retrospect.real.end_us is None:
        until = period_of(retrospect).when(retrospect.real.until_us)
        yield f'the job has not ended: times and items are compared up to {until}'
    if retrospect.cell_differs:
        yield 'the node ran with another cell file than this one'


def _ends(retrospect: Retrospect, period: Period) -> Iterator[tuple[str, ...]]:
    ends = retrospect.forecast.end_us, retrospect.real.end_us
    texts = [UNKNOWN if end is None else period.clock(end) for end in ends]
    late_us = retrospect.late_us
    yield 'end', *texts, UNKNOWN if late_us is None else _more(late_us)


def _where(retrospect: Retrospect) -> Iterator[str]:
    pairs = [pair._replace(what=title_of(pair.what)) for pair in retrospect.times()]
    shown = [pair for pair in pairs if is_seen(pair.forecast) or is_seen(pair.real)]
    yield from _timed([*shown, retrospect.total])


def _timed(pairs: Iterable[Pair]) -> Iterator[str]:
    rows = [
        (pair.what, duration(pair.forecast), duration(pair.real), _more(pair.more))
        for pair in pairs
    ]
    if rows:
        yield from table(('', *_COLUMNS), rows)


def _tasks(retrospect: Retrospect) -> Iterator[str]:
    pairs = list(retrospect.tasks())
    rows = [
        (
            f'{pair.component} {pair.name}',
            str(pair.times),
            _each(pair.forecast_us, pair.times),
            _each(pair.real_us, pair.times),
            _more(pair.more_us),
        )
        for pair in pairs[:MOST_TASKS]
    ]
    if rows:
        yield from table(('', 'times', 'forecast each', 'real each', 'difference'), rows)
    if len(pairs) > MOST_TASKS:
        yield f'and {len(pairs) - MOST_TASKS} more'


def _deviations(retrospect: Retrospect, period: Period) -> Iterator[str]:
    for which, deviation in (
        ('first', retrospect.first_deviation()),
        ('worst', retrospect.worst_deviation()),
    ):
        if deviation is not None:
            yield ''
            yield f'{which} deviation, at {period.clock(deviation.real.end_us)}:'
            yield f'  {words_of(deviation)}'


def words_of(deviation: Deviation) -> str:
    """Say of an attempt how it went otherwise."""
    real, forecast = deviation.real, deviation.forecast
    end = f'failed: {real.reason}' if real.reason else 'ended'
    if forecast is None or deviation.late_us is None:
        return f'{_work(real)} {end}; it is not in the forecast'
    if not is_seen(deviation.late_us):
        return f'{_work(real)} {end}'
    began = _late(real.start_us - forecast.start_us)
    took = f'took {duration(real.took_us)}'
    if is_seen(real.took_us - forecast.took_us):
        took += f' in place of {duration(forecast.took_us)}'
    comma = ',' if real.reason else ''
    return f'{_work(real)} {end}{comma} {_late(deviation.late_us)}: it began {began} and {took}'


def _work(real: Work) -> str:
    key = real.key
    again = again_words(key.round, key.attempt)
    section = f'section {key.task.section}, ' if key.task.section else ''
    more = f', {again}' if again else ''
    return f'{section}{key.task} ({real.name}) at {real.component}{more}'


def _late(us: int) -> str:
    if not is_seen(us):
        return 'in time'
    return f'{duration(abs(us))} {"late" if us > 0 else "early"}'


def _counted(pair: Pair) -> tuple[str, ...]:
    more = f'{pair.more:+}' if pair.more else '='
    return pair.what.replace('_', ' '), str(pair.forecast), str(pair.real), more


def _each(us: int, times: int) -> str:
    return f'{us / times / 1e6:.2f} s'


def _more(us: int) -> str:
    if not is_seen(us):
        return '='
    return f'+{duration(us)}' if us > 0 else duration(us)


# A job beside its forecast, as plain data.


def retrospect_plain(retrospect: Retrospect) -> dict[str, Any]:
    """Return everything; times in seconds, null: not known."""
    times = retrospect.real.times
    return {
        'job': retrospect.job,
        'cell': times.cell or None,
        'started': period_of(retrospect).iso(retrospect.begin_us),
        'first_seq': retrospect.first_seq,
        'durations': 'usual' if retrospect.usual else 'cell file',
        'notes': list(notes(retrospect)),
        'forecast': _course(retrospect, retrospect.forecast),
        'real': _course(retrospect, retrospect.real),
        'late_s': seconds_of(retrospect.late_us),
        'items': [pair._asdict() for pair in retrospect.items()],
        'time': [_plain_times(pair) for pair in (*retrospect.times(), retrospect.total)],
        'components': [_plain_times(pair) for pair in retrospect.busy()],
        'tasks': [
            {
                'component': task.component,
                'task': task.name,
                'times': task.times,
                'forecast_s': seconds_of(task.forecast_us),
                'real_s': seconds_of(task.real_us),
            }
            for task in retrospect.tasks()
        ],
        'first_deviation': _deviation(retrospect, retrospect.first_deviation()),
        'worst_deviation': _deviation(retrospect, retrospect.worst_deviation()),
        'stops': [stop_plain(stop) for stop in times.stops],
        'holds': [held_plain(held, period_of(retrospect)) for held in times.holds],
        'failed_attempts': [summed(failure) for failure in times.failing],
    }


def _course(retrospect: Retrospect, course: Course) -> dict[str, Any]:
    when = period_of(retrospect).iso
    return {
        'end': None if course.end_us is None else when(course.end_us),
        'compared_to': when(course.until_us),
    }


def _plain_times(pair: Pair) -> dict[str, Any]:
    seconds = seconds_of(pair.forecast), seconds_of(pair.real)
    return {'what': pair.what, 'forecast_s': seconds[0], 'real_s': seconds[1]}


def _deviation(retrospect: Retrospect, deviation: Deviation | None) -> dict[str, Any] | None:
    if deviation is None:
        return None
    task = deviation.real.key.task
    return {
        'words': words_of(deviation),
        'section': task.section,
        'item': task.item,
        'task': task.task,
        'name': deviation.real.name,
        'component': deviation.real.component,
        'round': deviation.real.key.round,
        'attempt': deviation.real.key.attempt,
        'reason': deviation.real.reason or None,
        'late_s': seconds_of(deviation.late_us),
        'forecast': None
        if deviation.forecast is None
        else _plain_work(retrospect, deviation.forecast),
        'real': _plain_work(retrospect, deviation.real),
    }


def _plain_work(retrospect: Retrospect, work: Work) -> dict[str, Any]:
    when = period_of(retrospect).iso
    return {'from': when(work.start_us), 'to': when(work.end_us)}
