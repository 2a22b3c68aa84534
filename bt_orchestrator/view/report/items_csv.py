"""Export of a job's items as CSV: one row an item, for a spreadsheet."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from typing import IO, Any

from bt_orchestrator.model.jobs.job_record import ItemRecord, JobRecord
from bt_orchestrator.view.report.csv_export import csv_cell, iso_time

COLUMNS = (
    'job',
    'item',
    'how',
    'started',
    'ended',
    'seconds',
    'nonconforming',
    'failures',
    'rounds',
    'serial',
    'recipe',
    'recipe_version',
)
"""The same for every job; its lots follow, and the results of its tasks, one column a field."""


_LOTS = 'lots.'


def write_items(job: JobRecord, file: IO[str]) -> None:
    """Write RFC 4180 with a header, times as ISO 8601 in UTC.

    A column of results has the name that a reference in a script has
    (`results.inspect.measurement`), that of a lot its name (`lots.glue`).
    """
    fields = list(dict.fromkeys(name for item in job.items.values() for name, _ in _told(item)))
    fields.sort(key=lambda name: not name.startswith(_LOTS))
    writer = csv.writer(file)
    writer.writerow([*COLUMNS, *map(csv_cell, fields)])
    for item in job.items.values():
        told = dict(_told(item))
        row = [*_about(job, item), *(told.get(name) for name in fields)]
        writer.writerow(map(csv_cell, row))


def _about(job: JobRecord, item: ItemRecord) -> tuple[Any, ...]:
    ended, seconds = item.ended, item.seconds
    return (
        job.job,
        item.item,
        item.how,
        iso_time(item.started),
        None if ended is None else iso_time(ended),
        None if seconds is None else round(seconds, 3),
        ' '.join(item.nonconforming),
        sum(failure.item == item.item for failure in job.failures),
        sum(item.rounds.values()),
        item.serial,
        job.recipe,
        job.recipe_version,
    )


def _told(item: ItemRecord) -> Iterator[tuple[str, Any]]:
    for name, lot in item.lots.items():
        yield f'{_LOTS}{name}', lot
    for task, results in item.results.items():
        for name, value in results.items():
            yield f'results.{task}.{name}', value
