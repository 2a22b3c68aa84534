"""The figures of a run as text for a person, and those of two runs side by side."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from bt_orchestrator.base.errors import counted
from bt_orchestrator.view.report.forecast import (
    Bottleneck,
    Forecast,
    JobForecast,
    SectionLoad,
    WaitLoad,
)
from bt_orchestrator.view.report.pace_text import ScriptPace
from bt_orchestrator.view.report.tables import table

_LOSSES = ('rejected', 'missing', 'nonconforming')

WAITS_SHOWN = 5
"""The number of waits in the output for each section and component, the longest; the rest is
summed up."""


def summary_lines(forecast: Forecast, paces: Sequence[ScriptPace] = ()) -> Iterator[str]:
    """Yield how jobs end, how fast the line is, and what limits it.

    :param paces: of its scripts, to compare with what was measured
    """
    yield from job_lines(forecast)
    yield ''
    yield from _full_line(paces)
    if forecast.per_item_s is not None:
        of_mix = ', the mean of the mix' if forecast.is_mix else ''
        yield f'time per item  {forecast.per_item_s:.1f} s in steady state{of_mix}'
    if forecast.bottleneck is not None:
        yield f'bottleneck     {bottleneck_words(forecast.bottleneck)}'
    if forecast.is_mix:
        yield from _each_of_mix(forecast.jobs)
    if forecast.changeover_s:
        yield f'changes        {forecast.changeover_s:.1f} s of setups'
    yield f'total time     {forecast.total_s:.1f} s'


def detail_lines(forecast: Forecast) -> Iterator[str]:
    """Yield how busy each section and component was, and what it waited for."""
    headers = ('section', 'cycles', 'busy', 'per cycle', 'best pace')
    yield from table(headers, [_section(load) for load in forecast.sections])
    yield ''
    yield from table(
        ('component', 'tasks', 'busy', 'utilisation'),
        [
            (load.component, str(load.tasks), f'{load.busy_s:.1f} s', f'{load.utilisation:.1%}')
            for load in forecast.components
        ],
    )
    yield from _wait_lines(forecast)


def bottleneck_words(bottleneck: Bottleneck) -> str:
    """Say which section it is, and by how much."""
    text = f'section {bottleneck.section}, at best {bottleneck.pace_s:.1f} s per item'
    if bottleneck.next_section is None:
        return text
    margin_s = bottleneck.margin_s
    share = margin_s / bottleneck.pace_s if bottleneck.pace_s else 0.0
    if round(margin_s, 1) == 0.0:
        return f'{text}; section {bottleneck.next_section} is as slow'
    return (
        f'{text}; section {bottleneck.next_section} is next, {margin_s:.1f} s ({share:.0%}) faster'
    )


def _full_line(paces: Sequence[ScriptPace]) -> Iterator[str]:
    """Yield how fast the line is with each script once it is full, which needs no run."""
    for pace in paces:
        of_script = f'of {pace.script}: ' if len(paces) > 1 else ''
        for number, line in enumerate(pace.lines()):
            text = line.removeprefix('pace: ')
            yield f'{"" if number else "pace":<13}  {"" if number else of_script}{text}'


def _each_of_mix(jobs: Sequence[JobForecast]) -> Iterator[str]:
    """Yield how fast each product is made, and what limits it."""
    for job in jobs:
        if job.bottleneck is not None:
            per_item = _seconds(job.per_item_s)
            yield f'  {job.job}: {per_item}; bottleneck {bottleneck_words(job.bottleneck)}'


def _wait_lines(forecast: Forecast) -> Iterator[str]:
    """Yield the waits of all parts that have any."""
    sections = [(f'section {load.section}', load) for load in forecast.sections]
    components = [(load.component, load) for load in forecast.components]
    for title, loads in (('sections', sections), ('components', components)):
        waiting = [(name, load) for name, load in loads if load.waits]
        if waiting:
            yield from ('', f'where the time of the {title} goes:')
        for name, load in waiting:
            yield f'  {name}'
            yield f'    {load.utilisation:6.1%}  works'
            yield from _longest(load.waits)


def _longest(waits: Sequence[WaitLoad]) -> Iterator[str]:
    for wait in waits[:WAITS_SHOWN]:
        yield f'    {wait.share:6.1%}  waits for {wait.cause}'
    rest = waits[WAITS_SHOWN:]
    if rest:
        each = f', at most {rest[0].share:.1%} each' if len(rest) > 1 else ''
        share = sum(wait.share for wait in rest)
        yield f'    {share:6.1%}  {counted(len(rest), "other wait")}{each}'


def job_lines(forecast: Forecast) -> Iterator[str]:
    """Yield how each job goes; without what became of items if all are good."""
    losses = [loss for loss in _LOSSES if any(getattr(job, loss) for job in forecast.jobs)]
    headers = ('job', 'script', 'items', 'packed', *losses, 'per item', 'finished')
    yield from table(headers, [_job(job, losses) for job in forecast.jobs])


def _job(job: JobForecast, losses: Sequence[str]) -> tuple[str, ...]:
    counts = (job.quantity, job.packed, *(getattr(job, loss) for loss in losses))
    return (job.job, job.script, *map(str, counts), _seconds(job.per_item_s), _finish(job))


def _finish(job: JobForecast) -> str:
    end = _seconds(job.finished_s)
    return f'aborted {end}' if job.aborted else end


def _section(load: SectionLoad) -> tuple[str, ...]:
    times = (load.busy_s, load.busy_per_cycle_s, load.pace_s)
    return (str(load.section), str(load.cycles), *map(_seconds, times))


def _seconds(time_s: float | None) -> str:
    return '-' if time_s is None else f'{time_s:.1f} s'


# The figures of two runs side by side.


class Change(NamedTuple):
    """One figure of two runs."""

    what: str
    before: float | None
    after: float | None
    unit: str
    """s, or % for parts of the time."""

    @property
    def percent(self) -> float | None:
        """Relative change; None where it has no meaning, as for parts of the time."""
        if self.unit == '%' or self.after is None or not self.before:
            return None
        return (self.after - self.before) / self.before * 100.0


def changes(before: Forecast, after: Forecast) -> Iterator[Change]:
    """Yield the figures of two runs."""
    yield Change('total time', before.total_s, after.total_s, 's')
    if before.changeover_s or after.changeover_s:
        yield Change('changes of setups', before.changeover_s, after.changeover_s, 's')
    yield Change('time per item', before.per_item_s, after.per_item_s, 's')
    ends = {job.job: job.finished_s for job in after.jobs}
    for job in before.jobs:
        yield Change(f'{job.job} finished', job.finished_s, ends.get(job.job), 's')
    paces = {load.section: load.pace_s for load in after.sections}
    for load in before.sections:
        what = f'section {load.section}, an item every'
        yield Change(what, load.pace_s, paces.get(load.section), 's')
    works = {load.component: load.utilisation for load in after.components}
    for component in before.components:
        share = works.get(component.component)
        after_share = None if share is None else share * 100
        what = f'{component.component} works'
        yield Change(what, component.utilisation * 100, after_share, '%')


def comparison_lines(before: Forecast, after: Forecast) -> Iterator[str]:
    """Yield the comparison as text."""
    rows = [_row(change) for change in changes(before, after)]
    yield from table(('', 'before', 'after', 'change'), rows)
    yield ''
    yield _bottleneck(before, after)


def _row(change: Change) -> tuple[str, ...]:
    return (
        change.what,
        _figure(change.before, change.unit),
        _figure(change.after, change.unit),
        _difference(change),
    )


def _figure(value: float | None, unit: str) -> str:
    return '-' if value is None else f'{value:.1f} {unit}'


def _difference(change: Change) -> str:
    if change.before is None or change.after is None:
        return '-'
    if abs(change.after - change.before) < 0.05:
        return '='
    if change.percent is None:
        return f'{change.after - change.before:+.1f} points'
    return f'{change.percent:+.1f} %'


def _bottleneck(before: Forecast, after: Forecast) -> str:
    old, new = before.bottleneck, after.bottleneck
    if old is None or new is None:
        return 'bottleneck: nothing was worked on'
    if old.section == new.section:
        return f'bottleneck: section {old.section} before and after'
    return f'bottleneck: from section {old.section} to section {new.section}'
