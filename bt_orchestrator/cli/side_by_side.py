"""Two virtual runs side by side: the orders unchanged, and with another cell file or script."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from bt_orchestrator.cli import bootstrap
from bt_orchestrator.cli.virtual_run import Run, lines_of, plain
from bt_orchestrator.cli.wrong_use import WrongUse
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.ports import ActionTypes
from bt_orchestrator.script.file_kind import FileKind, file_kind
from bt_orchestrator.script.script_file import read_script
from bt_orchestrator.sim.simulation import Outcome
from bt_orchestrator.view.report.comparison import changes, comparison_lines


class OrderFiles(NamedTuple):
    """Work orders, and where what they need is found."""

    orders: Sequence[Path]
    cell: Path
    trees: Sequence[Path]
    recipes: Sequence[Path]

    def jobs(
        self, types: ActionTypes, instead: bootstrap.Replacement | None = None
    ) -> tuple[Cell, list[bootstrap.Given]]:
        """Read them, and bind them to jobs.

        :raises Refused: with every mistake in all files
        """
        trees, recipes = self.trees, self.recipes
        return bootstrap.load_jobs(self.orders, self.cell, trees, types, instead, recipes)


def what_if_jobs(
    file: Path, orders: OrderFiles, types: ActionTypes, scripts: Sequence[str]
) -> tuple[Cell, list[bootstrap.Given]]:
    """Read the orders again, for the cell or with the script that a file describes.

    :param scripts: names of the scripts that the orders ask for
    :raises Refused: with every mistake in all files
    :raises WrongUse: it is not clear which script it would take the place of
    """
    if file_kind(file) is FileKind.CELL:
        return orders._replace(cell=file).jobs(types)
    name = read_script(file, bootstrap.load_cell(orders.cell, types), types).name
    asked = list(dict.fromkeys(scripts))
    if name not in asked and len(asked) > 1:
        raise WrongUse(
            f'{file} is script {name}, and the orders ask for {", ".join(asked)}; '
            'give it the name of the one whose place it takes'
        )
    instead = bootstrap.Replacement(name if name in asked else asked[0], file)
    return orders.jobs(types, instead)


def change_lines(before: Run, after: Run) -> Iterator[str]:
    """Yield the comparison as text; runs that did not end are shown in full."""
    for name, done in (('before', before), ('after', after)):
        if done.outcome is not Outcome.FINISHED:
            yield f'{name}:'
            yield from (f'  {line}' for line in lines_of(done))
            yield ''
    yield from comparison_lines(before.forecast, after.forecast)
    for name, done in (('before', before), ('after', after)):
        for one in done.paces:
            of_script = f'{one.script}: ' if len(done.paces) > 1 else ''
            yield f'{name}, {of_script}{one.pace or "the line gets stuck"}'


def plain_change(before: Run, after: Run) -> dict[str, Any]:
    """Return the comparison as data that JSON can carry."""
    found = changes(before.forecast, after.forecast)
    return {
        'ok': before.outcome is after.outcome is Outcome.FINISHED,
        'before': plain(before),
        'after': plain(after),
        'changes': [{**one._asdict(), 'percent': one.percent} for one in found],
        'findings': [],
    }
