"""The Gantt chart of what really happened, a row a component."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import replace
from datetime import datetime
from typing import NamedTuple

from bt_orchestrator.base.errors import OrchestratorError
from bt_orchestrator.cli.output import WrongUse
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.jobs.job_record import ItemRecord, JobRecord
from bt_orchestrator.model.keeping.records import Wanted
from bt_orchestrator.view.drawing.gantt import Gantt, GanttFold
from bt_orchestrator.view.drawing.gantt_page import gantt_svg
from bt_orchestrator.view.report.account.account import of_job
from bt_orchestrator.view.report.account.booked import steady_time
from bt_orchestrator.view.report.account.planned import US, us_of
from bt_orchestrator.view.report.account.steady_time import SteadyTime, Step
from bt_orchestrator.view.report.reading import Reading

MOST_TASKS = 20_000
"""A chart of more attempts is a file of some 10 MB, which browsers show slowly."""

LOOK_BACK_US = 3600 * US
"""A task that runs when the chart begins is found if it began within this time before."""

_FAR_US = 1 << 60

_FOLLOWED = ('task.', 'hold.', 'job.queued')


class NothingThere(OrchestratorError):
    """Nothing happened in the time of a chart."""


class _Window(NamedTuple):
    begin_us: int
    end_us: int
    steady: SteadyTime
    """Goes on as the clock did when the chart begins; all times of the chart are of it."""

    @property
    def steps(self) -> Sequence[Step]:
        """Steps of the clock within it."""
        return self.steady.within(self.begin_us + 1, self.end_us)


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
    gantt = fold.past(window.begin_us / US, window.end_us / US)
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
    steady = window.steady
    since, until = steady.clock_span(window.begin_us - LOOK_BACK_US, window.end_us)
    wanted = Wanted(since=since / US, until=(until + 0.5) / US, events=_FOLLOWED)
    for event in map(steady.of, reading.events(wanted)):
        if us_of(event.time) <= window.end_us:
            yield event


def _window(reading: Reading, args: argparse.Namespace) -> _Window:
    """Return the time that is meant; without options it is all that the journal has.

    :raises NothingThere: the journal has nothing of it
    """
    first, last = reading.first(Wanted()), reading.first(Wanted(newest_first=True))
    if first is None or last is None:
        raise NothingThere(
            f'the journal {args.journal} has no events; name that of a node that ran'
        )
    steady = steady_time(reading)
    if args.job is not None:
        _refuse_nothing(reading, args)
        period = of_job(reading, args.job, str(args.journal))
        begin, end = period.begin_us, period.end_us
    else:
        begin, end = _shown(steady, args, steady.us(first), steady.us(last))
    ahead = steady.ahead_at(begin)
    return _Window(begin + ahead, end + ahead, steady.as_shown_at(begin))


def _shown(steady: SteadyTime, args: argparse.Namespace, first: int, last: int) -> Sequence[int]:
    """Return from when to when the clock showed the times of --from and --to.

    :raises NothingThere: it showed none of them
    """
    since = first - _FAR_US if args.since is None else us_of(args.since)
    until = last + _FAR_US if args.until is None else us_of(args.until)
    spans = steady.when_shown([(since, until + 1)])
    if not spans:
        raise NothingThere(f'the clock skipped all of that time, by the journal {args.journal}')
    begin = first if args.since is None else spans[0][0]
    return begin, min(spans[-1][1] - 1, last)


def _refuse_nothing(reading: Reading, args: argparse.Namespace) -> None:
    """Refuse a job that has no events from its start on.

    :raises NothingThere: it is one
    """
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


def _titled(gantt: Gantt, window: _Window) -> Gantt:
    jobs = ', '.join(gantt.jobs)
    steps = '; '.join(map(_set_words, window.steps))
    goes_on = f'; {steps}: times go on as if it had not been set' if steps else ''
    return gantt.named(f'{jobs + ": " if jobs else ""}what happened {_when(window)}{goes_on}')


def _set_words(step: Step) -> str:
    way = 'back' if step.by_us < 0 else 'forward'
    return f'the clock was set {way} by {abs(step.by_us) / US:.0f} s at {_iso(step.at_us)}'


def _when(window: _Window) -> str:
    return f'from {_iso(window.begin_us)} to {_iso(window.end_us)}'


def _iso(us: int) -> str:
    return datetime.fromtimestamp(us / US).isoformat(' ', 'seconds')


# The jobs and items of a journal that the options of the verb `history` choose.


def jobs_meant(reading: Reading, args: argparse.Namespace) -> list[JobRecord]:
    """Read the jobs that may be meant; for items that are named, theirs alone."""
    names = {item.rpartition('/')[0] for item in args.item or ()}
    job = args.job or (names.pop() if len(names) == 1 else None)
    return [record for record in reading.jobs(job).jobs.values() if _is_wanted(record, args)]


def with_items(jobs: Sequence[JobRecord], args: argparse.Namespace) -> Iterator[JobRecord]:
    """Yield the jobs that have the items chosen, with these items only."""
    for job in jobs:
        items = {name: item for name, item in job.items.items() if _is_meant(item, args)}
        if items:
            failures = [failure for failure in job.failures if failure.item in items]
            yield replace(job, items=items, failures=failures)


def _is_meant(item: ItemRecord, args: argparse.Namespace) -> bool:
    is_lot = args.lot is None or item.lots.get(args.lot[0]) == args.lot[1]
    is_named = args.item is None or item.item in args.item
    return is_lot and is_named and args.serial in (None, item.serial)


def _is_wanted(job: JobRecord, args: argparse.Namespace) -> bool:
    return (
        args.job in (None, job.job)
        and (args.since is None or job.queued >= args.since)
        and (args.until is None or job.queued <= args.until)
    )


def no_job(args: argparse.Namespace) -> str:
    """Say that a journal knows nothing of the job that is named."""
    known = f'bt-orchestrator history --journal {args.journal}'
    return f'the journal {args.journal} knows no job {args.job}; {known} lists those it has'


def no_item(args: argparse.Namespace) -> str:
    """Say that a journal does not have the chosen items."""
    if not args.item:
        return f'the journal {args.journal} has no such item any more'
    named = ' and no '.join(args.item)
    return (
        f'the journal {args.journal} knows no item {named}: it never was, or its events are not '
        'kept any more; history --job JOB --items names the items of a job'
    )
