"""The Gantt chart of what really happened, a row a component."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from datetime import datetime
from typing import NamedTuple

from bt_orchestrator.cli.history.choosing import no_job
from bt_orchestrator.cli.wrong_use import WrongUse
from bt_orchestrator.drawing.gantt import Gantt, GanttFold
from bt_orchestrator.drawing.gantt_page import gantt_svg
from bt_orchestrator.errors import OrchestratorError
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.records import Wanted
from bt_orchestrator.report.reading import Reading

MOST_TASKS = 20_000
"""A chart of more attempts is a file of some 10 MB, which browsers show slowly."""

LOOK_BACK_S = 3600.0
"""What ran when the chart begins is found if it began within this time before."""

_FOLLOWED = ('task.', 'hold.', 'job.queued')


class NothingThere(OrchestratorError):
    """Nothing happened in the time of a chart."""


class _Window(NamedTuple):
    begin_s: float
    end_s: float


def chart_svg(reading: Reading, args: argparse.Namespace) -> str:
    """Draw what each component did in the time of a job, or of --from and --to.

    :raises NothingThere: no component worked in that time
    :raises WrongUse: it is too much for one chart
    """
    window = _window(reading, args)
    fold, count = GanttFold(by_component=True), 0
    for event in _events(reading, window):
        fold.follow(event)
        count += event.event == 'task.started'
        refuse_too_many(count)
    gantt = fold.past(window.begin_s, window.end_s)
    if not gantt.rows:
        raise NothingThere(
            f'no component worked {_when(window)}, by the journal {args.journal}; choose another '
            'time, with --from and --to'
        )
    return gantt_svg(_titled(gantt, window))


def refuse_too_many(attempts: int) -> None:
    """Refuse what makes no chart.

    :raises WrongUse: there are too many attempts
    """
    if attempts > MOST_TASKS:
        raise WrongUse(
            f'more than {MOST_TASKS} attempts are too many for one chart: choose less with '
            '--job, or with --from and --to'
        )


def _events(reading: Reading, window: _Window) -> Iterator[Event]:
    wanted = Wanted(since=window.begin_s - LOOK_BACK_S, until=window.end_s, events=_FOLLOWED)
    yield from reading.events(wanted)


def _window(reading: Reading, args: argparse.Namespace) -> _Window:
    """Return the time that is meant; without options it is all that the journal has.

    :raises NothingThere: the journal has nothing of it
    """
    first, last = reading.first(Wanted()), reading.first(Wanted(newest_first=True))
    if first is None or last is None:
        raise NothingThere(
            f'the journal {args.journal} has no events; name that of a node that ran'
        )
    if args.job is None:
        begin = first.time if args.since is None else args.since
        return _Window(begin, last.time if args.until is None else min(args.until, last.time))
    job = reading.jobs(args.job).jobs.get(args.job)
    if job is None:
        raise NothingThere(no_job(args))
    if job.started is None or not job.complete:
        why = (
            'it has not started yet'
            if job.started is None
            else 'its events are not kept any more; a backup of the journal may have them'
        )
        raise NothingThere(f'there is nothing to draw of job {args.job}: {why}')
    return _Window(job.started, last.time if job.ended is None else job.ended)


def _titled(gantt: Gantt, window: _Window) -> Gantt:
    jobs = ', '.join(gantt.jobs)
    return gantt.named(f'{jobs + ": " if jobs else ""}what happened {_when(window)}')


def _when(window: _Window) -> str:
    begin, end = (datetime.fromtimestamp(at).isoformat(' ', 'seconds') for at in window)
    return f'from {begin} to {end}'
