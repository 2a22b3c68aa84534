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


def period_of(found: Retrospect) -> Period:
    """Return the time of a job."""
    begin_us, until_us = found.begin_us, found.real.until_us
    return Period.all_planned(f'job {found.job}', begin_us, until_us, found.steady)


def retrospect_text(found: Retrospect) -> Iterator[str]:
    """Yield the lines; each part is left out where it has nothing to say."""
    period, times = period_of(found), found.real.times
    cell = f'cell {times.cell}, ' if times.cell else ''
    yield f'{cell}job {found.job}, started {period.when(found.begin_us)}: forecast and reality'
    yield from (f'  {note}' for note in notes(found))
    yield ''
    yield from table(('', *_COLUMNS), [*_ends(found, period), *map(_counted, found.items())])
    yield from titled('where the time went', _where(found))
    yield from titled('at work', _timed(found.busy()))
    yield from titled('tasks that took longer or shorter', _tasks(found))
    yield from _deviations(found, period)
    yield from titled('stops, the longest first', stop_lines(times))
    yield from titled('holds', hold_lines(times, period))
    yield from titled('failed attempts', failing_lines(times))


def notes(found: Retrospect) -> Iterator[str]:
    """Say what the forecast is, and what limits it."""
    durations = 'that tasks had taken before' if found.usual else 'of the cell file'
    run = f'a virtual run from event {found.first_seq} on'
    yield f'the forecast is {run}, with the durations {durations}'
    if found.real.end_us is None:
        until = period_of(found).when(found.real.until_us)
        yield f'the job has not ended: times and items are compared up to {until}'
    if found.cell_differs:
        yield 'the node ran with another cell file than this one'


def _ends(found: Retrospect, period: Period) -> Iterator[tuple[str, ...]]:
    ends = found.forecast.end_us, found.real.end_us
    told = [UNKNOWN if end is None else period.clock(end) for end in ends]
    late_us = found.late_us
    yield 'end', *told, UNKNOWN if late_us is None else _more(late_us)


def _where(found: Retrospect) -> Iterator[str]:
    pairs = [pair._replace(what=title_of(pair.what)) for pair in found.times()]
    shown = [pair for pair in pairs if is_seen(pair.forecast) or is_seen(pair.real)]
    yield from _timed([*shown, found.total])


def _timed(pairs: Iterable[Pair]) -> Iterator[str]:
    rows = [
        (pair.what, duration(pair.forecast), duration(pair.real), _more(pair.more))
        for pair in pairs
    ]
    if rows:
        yield from table(('', *_COLUMNS), rows)


def _tasks(found: Retrospect) -> Iterator[str]:
    pairs = list(found.tasks())
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


def _deviations(found: Retrospect, period: Period) -> Iterator[str]:
    for which, one in (('first', found.first_deviation()), ('worst', found.worst_deviation())):
        if one is not None:
            yield ''
            yield f'{which} deviation, at {period.clock(one.real.end_us)}:'
            yield f'  {words_of(one)}'


def words_of(one: Deviation) -> str:
    """Say of an attempt how it went otherwise."""
    real, forecast = one.real, one.forecast
    end = f'failed: {real.reason}' if real.reason else 'ended'
    if forecast is None or one.late_us is None:
        return f'{_work(real)} {end}; it is not in the forecast'
    if not is_seen(one.late_us):
        return f'{_work(real)} {end}'
    began = _late(real.start_us - forecast.start_us)
    took = f'took {duration(real.took_us)}'
    if is_seen(real.took_us - forecast.took_us):
        took += f' in place of {duration(forecast.took_us)}'
    comma = ',' if real.reason else ''
    return f'{_work(real)} {end}{comma} {_late(one.late_us)}: it began {began} and {took}'


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
        'time': [_plain_times(pair) for pair in (*found.times(), found.total)],
        'components': [_plain_times(pair) for pair in found.busy()],
        'tasks': [
            {
                'component': task.component,
                'task': task.name,
                'times': task.times,
                'forecast_s': seconds_of(task.forecast_us),
                'real_s': seconds_of(task.real_us),
            }
            for task in found.tasks()
        ],
        'first_deviation': _deviation(found, found.first_deviation()),
        'worst_deviation': _deviation(found, found.worst_deviation()),
        'stops': [stop_plain(stop) for stop in times.stops],
        'holds': [held_plain(held, period_of(found)) for held in times.holds],
        'failed_attempts': [summed(one) for one in times.failing],
    }


def _course(found: Retrospect, course: Course) -> dict[str, Any]:
    when = period_of(found).iso
    return {
        'end': None if course.end_us is None else when(course.end_us),
        'compared_to': when(course.until_us),
    }


def _plain_times(pair: Pair) -> dict[str, Any]:
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
        'forecast': None if one.forecast is None else _plain_work(found, one.forecast),
        'real': _plain_work(found, one.real),
    }


def _plain_work(found: Retrospect, work: Work) -> dict[str, Any]:
    when = period_of(found).iso
    return {'from': when(work.start_us), 'to': when(work.end_us)}
