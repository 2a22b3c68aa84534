"""Two virtual runs side by side: the orders as they are, and with another cell file or script."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from bt_orchestrator.cli import bootstrap
from bt_orchestrator.cli.tables import table
from bt_orchestrator.cli.virtual_run import Run, lines_of, plain
from bt_orchestrator.cli.wrong_use import WrongUse
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.script.file_kind import FileKind, file_kind
from bt_orchestrator.script.script_file import read_script
from bt_orchestrator.sim.simulation import Outcome


class Change(NamedTuple):
    """One figure of two runs."""

    what: str
    before: float | None
    after: float | None
    unit: str
    """s, or % for parts of the time."""

    @property
    def percent(self) -> float | None:
        """By how much it changed; None where that says nothing, as for parts of the time."""
        if self.unit == '%' or self.after is None or not self.before:
            return None
        return (self.after - self.before) / self.before * 100.0


def what_if_jobs(
    file: Path,
    orders: Sequence[Path],
    cell_file: Path,
    folders: Sequence[Path],
    types: ActionTypes,
    scripts: Sequence[str],
) -> tuple[Cell, list[bootstrap.Given]]:
    """Read the orders again, for the cell or with the script that a file describes.

    :param scripts: names of the scripts that the orders ask for
    :raises Refused: with every mistake in all files
    :raises WrongUse: it is not clear which script it would take the place of
    """
    if file_kind(file) is FileKind.CELL:
        return bootstrap.load_jobs(orders, file, folders, types)
    name = read_script(file, bootstrap.load_cell(cell_file, types), types).name
    asked = list(dict.fromkeys(scripts))
    if name not in asked and len(asked) > 1:
        raise WrongUse(
            f'{file} is script {name}, and the orders ask for {", ".join(asked)}; '
            'give it the name of the one whose place it takes'
        )
    instead = bootstrap.Replacement(name if name in asked else asked[0], file)
    return bootstrap.load_jobs(orders, cell_file, folders, types, instead)


def changes(before: Run, after: Run) -> Iterator[Change]:
    """Yield the figures of both runs."""
    old, new = before.forecast, after.forecast
    yield Change('total time', old.total_s, new.total_s, 's')
    yield Change('time per item', old.per_item_s, new.per_item_s, 's')
    ends = {job.job: job.finished_s for job in new.jobs}
    for job in old.jobs:
        yield Change(f'{job.job} finished', job.finished_s, ends.get(job.job), 's')
    paces = {load.section: load.pace_s for load in new.sections}
    for load in old.sections:
        what = f'section {load.section}, an item every'
        yield Change(what, load.pace_s, paces.get(load.section), 's')
    works = {load.component: load.utilisation for load in new.components}
    for component in old.components:
        share = works.get(component.component)
        after_share = None if share is None else share * 100
        what = f'{component.component} works'
        yield Change(what, component.utilisation * 100, after_share, '%')


def change_lines(before: Run, after: Run) -> Iterator[str]:
    """Yield the comparison as text; what did not end is told in full."""
    for name, done in (('before', before), ('after', after)):
        if done.outcome is not Outcome.FINISHED:
            yield f'{name}:'
            yield from (f'  {line}' for line in lines_of(done))
            yield ''
    rows = [_row(change) for change in changes(before, after)]
    yield from table(('', 'before', 'after', 'change'), rows)
    yield ''
    yield _bottleneck(before, after)


def plain_change(before: Run, after: Run) -> dict[str, Any]:
    """Return the comparison as data that JSON can carry."""
    return {
        'ok': before.outcome is after.outcome is Outcome.FINISHED,
        'before': plain(before),
        'after': plain(after),
        'changes': [
            {**change._asdict(), 'percent': change.percent} for change in changes(before, after)
        ],
        'findings': [],
    }


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


def _bottleneck(before: Run, after: Run) -> str:
    old, new = before.forecast.bottleneck, after.forecast.bottleneck
    if old is None or new is None:
        return 'bottleneck: nothing was worked on'
    if old.section == new.section:
        return f'bottleneck: section {old.section} before and after'
    return f'bottleneck: from section {old.section} to section {new.section}'
