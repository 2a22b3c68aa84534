"""The export: a folder with two tables, one row an event, and one an attempt of a task."""

from __future__ import annotations

import json
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import json_of, known_event
from bt_orchestrator.model.task_spans import TaskSpan, TaskSpans
from bt_orchestrator.view.report.account.planned import US, us_of
from bt_orchestrator.view.report.account.steady_time import SteadyTime
from bt_orchestrator.view.report.csv_export import COLUMNS, LEFT_OUT


class ParquetExport:
    """Writes `events.parquet` and `tasks.parquet`."""

    def __init__(
        self,
        folder: Path,
        history: str,
        steady: SteadyTime | None = None,
        starts: Iterable[int] = (),
    ) -> None:
        """Begin.

        :param history: of the journal; kept with the tables
        :param steady: what is known of the steps of its clock; None: what the records say
        :param starts: events with which a node was started
        :raises OSError: the folder cannot be written
        """
        folder.mkdir(parents=True, exist_ok=True)
        about = {'bt_orchestrator.history': history}
        self._events = TableFile(folder / 'events.parquet', EVENTS, about)
        self._tasks = TableFile(folder / 'tasks.parquet', TASKS, about)
        self._rows = TaskRows(steady or SteadyTime(), starts)

    def write(self, text: str) -> None:
        """Take in one record, as JSON."""
        record = json.loads(text)
        self._events.add(event_row(record))
        event = known_event(record)
        if event is not None:
            for row in self._rows.follow(event):
                self._tasks.add(row)

    def close(self) -> None:
        """Complete both files."""
        for row in self._rows.open():
            self._tasks.add(row)
        self._events.close()
        self._tasks.close()

    def discard(self) -> None:
        """Leave nothing unfinished behind."""
        self._events.discard()
        self._tasks.discard()


# A Parquet file that grows by row groups.

INT = pa.int64()
TEXT = pa.string()
SECONDS = pa.float64()
TIME = pa.timestamp('us', tz='UTC')
"""Given as whole microseconds since the epoch."""

MOST_ROWS = 50_000
MOST_CHARACTERS = 16_000_000
"""A row group is written with so many rows, or so much text: this is what is kept in memory."""


class TableFile:
    """Takes in one row after another. The file is at its place when it is complete."""

    def __init__(self, path: Path, columns: Mapping[str, pa.DataType], about: Mapping[str, str]):
        """Begin.

        :param about: kept with the table, as key-value metadata
        :raises OSError: it cannot be written
        """
        self._path = path
        self._unfinished = path.with_name(f'{path.name}.part')
        self._schema = pa.schema(columns.items(), metadata=dict(about))
        self._writer = pq.ParquetWriter(self._unfinished, self._schema)
        self._columns: dict[str, list[Any]] = {name: [] for name in columns}
        self._rows = self._characters = 0

    def add(self, row: Mapping[str, Any]) -> None:
        """Take in a row; what it does not name is null."""
        for name, values in self._columns.items():
            value = row.get(name)
            values.append(value if type(value) is not int or fits(value) else None)
            if isinstance(value, str):
                self._characters += len(value)
        self._rows += 1
        if self._rows >= MOST_ROWS or self._characters >= MOST_CHARACTERS:
            self._write_group()

    def close(self) -> None:
        """Write the rest, and put the file at its place."""
        self._write_group()
        self._writer.close()
        self._unfinished.replace(self._path)

    def discard(self) -> None:
        """Give it up."""
        self._writer.close()
        self._unfinished.unlink(missing_ok=True)

    def _write_group(self) -> None:
        if self._rows:
            arrays = [_array(values, self._schema.field(n).type) for n, values in self._items()]
            self._writer.write_table(pa.Table.from_arrays(arrays, schema=self._schema))
        for _, values in self._items():
            values.clear()
        self._rows = self._characters = 0

    def _items(self) -> Any:
        return self._columns.items()


def fits(number: int) -> bool:
    """Tell whether a number has 64 bits at most; one that has more is null."""
    return -(2**63) <= number < 2**63


def _array(values: list[Any], kind: pa.DataType) -> pa.Array:
    try:
        return pa.array(values, kind)
    except UnicodeEncodeError:  # half of a surrogate pair has no UTF-8; it is written out
        return pa.array([_whole(value) for value in values], kind)


def _whole(value: Any) -> Any:
    return value.encode('utf-8', 'backslashreplace').decode() if type(value) is str else value


# The rows of both tables: one an event, and one an attempt of a task.

_NUMBERS = ('seq', 'section', 'attempt', 'count', 'beat')
_MORE = 'more'

EVENTS = {name: TIME if name == 'time' else INT if name in _NUMBERS else TEXT for name in COLUMNS}
"""The columns of the CSV export, typed; `results` and `more` are JSON."""

TASKS = {
    'started': TIME,
    'ended': TIME,
    'seconds': SECONDS,
    'outcome': TEXT,
    'job': TEXT,
    'section': INT,
    'item': TEXT,
    'task': TEXT,
    'name': TEXT,
    'action': TEXT,
    'component': TEXT,
    'round': INT,
    'attempt': INT,
    'goal': TEXT,
    'reason': TEXT,
    'message': TEXT,
    'arguments': TEXT,
    'results': TEXT,
    'start_seq': INT,
    'end_seq': INT,
}

OPEN = 'open'
"""Outcome of an attempt whose end is not among the events."""


def event_row(record: Mapping[str, Any]) -> dict[str, Any]:
    """Return the row of a record; what fits in no column is in `more`."""
    row: dict[str, Any] = {'time': us_of(record['time'])}
    more = {}
    for name, value in record.items():
        if name == 'time' or name in LEFT_OUT:
            continue
        kind = EVENTS.get(name)
        if kind == TEXT and name != _MORE:
            row[name] = value if isinstance(value, str) else json_of(value)
        elif kind == INT and type(value) is int and fits(value):
            row[name] = value
        else:
            more[name] = value
    if more:
        row[_MORE] = json_of(more)
    return row


class TaskRows:
    """Takes in one event after another, and pairs the starts of attempts with their ends."""

    def __init__(self, steady: SteadyTime, starts: Iterable[int]) -> None:
        """Begin.

        :param steady: knows when the clock was set
        :param starts: events with which a node was started, also such as are not taken in here
        """
        self._spans = TaskSpans()
        self._steady = steady
        self._starts = list(starts)

    def follow(self, event: e.Event) -> Iterator[dict[str, Any]]:
        """Take in the next event; yields the attempts that are over by it."""
        self._steady.follow(event)
        if isinstance(event, e.OrchestratorStarted):
            if event.seq > max(self._starts[-1:], default=0):
                self._starts.append(event.seq)
        elif isinstance(event, e.TaskStarted):
            lost = self._spans.start_of(event)
            if lost is not None:
                yield self._begun(lost)
        span = self._spans.follow(event) if isinstance(event, e.TaskEvent) else None
        if span is not None:
            yield self._ended(span)

    def open(self) -> Iterator[dict[str, Any]]:
        """Yield the attempts that have no end."""
        yield from map(self._begun, self._spans.open())

    def _begun(self, event: e.TaskStarted) -> dict[str, Any]:
        return {
            'started': us_of(event.time),
            'outcome': OPEN,
            **event.key._asdict(),
            'name': event.name,
            'action': event.action,
            'component': event.component,
            'round': event.round,
            'attempt': event.attempt,
            'goal': event.goal,
            'arguments': json_of(event.args),
            'start_seq': event.seq,
        }

    def _ended(self, span: TaskSpan) -> dict[str, Any]:
        begun, ended = span
        row = self._begun(begun)
        row |= {'ended': us_of(ended.time), 'end_seq': ended.seq}
        next_start = bisect_right(self._starts, begun.seq)
        if not any(start < ended.seq for start in self._starts[next_start : next_start + 1]):
            row['seconds'] = (self._steady.us(ended) - self._steady.us(begun)) / US
        if isinstance(ended, e.TaskFailed):
            return row | {'outcome': 'failed', 'reason': ended.reason, 'message': ended.message}
        return row | {'outcome': 'succeeded', 'results': json_of(ended.results)}
