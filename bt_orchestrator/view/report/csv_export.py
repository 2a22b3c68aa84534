"""Export as CSV: one row an event, the same columns for every journal; or one row an item."""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Iterator, Mapping
from datetime import datetime, timezone
from typing import IO, Any

from bt_orchestrator.model.codec import json_of
from bt_orchestrator.model.jobs.job_record import ItemRecord, JobRecord

COLUMNS = (
    *('seq', 'time', 'event', 'job', 'section', 'item', 'task', 'name', 'action', 'component'),
    *('attempt', 'goal', 'reason', 'message', 'hold', 'answer', 'who', 'how', 'flag', 'count'),
    *('beat', 'state', 'previous', 'results', 'more'),
)
"""New ones come at the end, before `more`: what has no column of its own, as JSON."""

LEFT_OUT = ('definition', 'cell_definition')
"""A whole script, a whole cell; they are in the jsonl export."""


class CsvExport:
    """Writes RFC 4180 with a header. Times are ISO 8601 in UTC, mappings are JSON."""

    def __init__(self, file: IO[str]) -> None:
        self._writer = csv.writer(file)
        self._writer.writerow(COLUMNS)

    def write(self, text: str) -> None:
        """Write one record."""
        record: dict[str, Any] = json.loads(text)
        record['time'] = iso_time(record['time'])
        more = {k: v for k, v in record.items() if k not in COLUMNS and k not in LEFT_OUT}
        if more:
            record['more'] = more
        self._writer.writerow([csv_cell(record.get(name)) for name in COLUMNS])

    def close(self) -> None:
        """Do nothing: every row is complete."""


def iso_time(seconds: float) -> str:
    """Return a time as programs read it, to the microsecond."""
    moment = datetime.fromtimestamp(seconds, timezone.utc)
    return moment.isoformat(timespec='microseconds')


def csv_cell(value: Any) -> Any:
    """Return a value for one cell of a table.

    A text that a spreadsheet would take for a formula gets an apostrophe in front, and so does a
    part of it that may come to begin a cell: where the decimal sign is a comma, spreadsheets part
    lines at semicolons. Characters that a terminal would obey are escaped. Names and messages come
    from devices and operators.
    """
    text = json_of(value) if isinstance(value, (Mapping, list)) else value
    if not isinstance(text, str):
        return text
    text = _CONTROLS.sub(lambda match: f'\\u{ord(match[0]):04x}', text)
    return _FORMULAS.sub("'", text)


_FORMULAS = re.compile(r'^(?=[=+\-@\t\r])|(?<=[;\t\r\n])(?="*[=+\-@])')
"""Where a formula may begin."""

_CONTROLS = re.compile('[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ud800-\udfff]')
"""All but tabs and ends of lines, which a cell may hold; half of a surrogate pair too."""


# Export of a job's items as CSV: one row an item, for a spreadsheet.

ITEM_COLUMNS = (
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
    writer.writerow([*ITEM_COLUMNS, *map(csv_cell, fields)])
    for item in job.items.values():
        values = dict(_told(item))
        row = [*_about(job, item), *(values.get(name) for name in fields)]
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
