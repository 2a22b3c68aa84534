"""The figures of two runs side by side."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from bt_orchestrator.view.report.forecast import Forecast
from bt_orchestrator.view.report.tables import table


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
