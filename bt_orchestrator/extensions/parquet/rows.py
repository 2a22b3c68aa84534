"""The rows of both tables: one an event, and one an attempt of a task."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from bt_orchestrator.extensions.parquet.table_file import INT, SECONDS, TEXT, TIME, fits
from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import json_of
from bt_orchestrator.model.task_spans import TaskSpan, TaskSpans
from bt_orchestrator.view.report.account.planned import US, us_of
from bt_orchestrator.view.report.account.steady_time import SteadyTime
from bt_orchestrator.view.report.csv_export import COLUMNS, LEFT_OUT

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
