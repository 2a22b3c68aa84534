"""Progress of a line in plain lines, one a step that a person would want to see."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from bt_orchestrator.model import events as e
from bt_orchestrator.model.hold_words import hold_words, why_words
from bt_orchestrator.model.task_spans import TaskSpan, TaskSpans


class Progress:
    """Turns the event stream into lines for a terminal or a log."""

    def __init__(self) -> None:
        self.held = False
        """An operator must answer, and nothing goes on."""
        self._start: float | None = None
        self._spans = TaskSpans()

    def follow(self, event: e.Event) -> Iterator[str]:
        """Yield the lines that an event deserves, usually none or one."""
        if self._start is None:
            self._start = event.time
        elif isinstance(event, e.ClockStepped):
            self._start += event.seconds
        for line in self._lines(event):
            yield f'{event.time - self._start:7.2f} s  {line}'

    def _lines(self, event: e.Event) -> Iterator[str]:
        span = self._spans.follow(event)
        if isinstance(event, e.CellStateChanged):
            self.held = event.state == 'Held'
        if span is not None and isinstance(event, e.TaskSucceeded):
            yield _succeeded(span)
        elif type(event) in _LINES:
            yield _LINES[type(event)](event)


def _succeeded(span: TaskSpan) -> str:
    started = span.started
    return f'{_place(started)}{started.name} at {started.action}, {span.seconds:.2f} s'


def _place(event: e.TaskEvent) -> str:
    if event.section is not None:
        return f'section {event.section:<3} {event.item}  '
    return f'initialization {event.job}  ' if event.job else 'belt        '


def _section(event: e.RoundBegun | e.ItemRemoved, what: str) -> str:
    return f'section {event.section:<3} {event.item}{what}'


def _cell_state(event: e.CellStateChanged) -> str:
    reason = f' ({event.reason})' if event.reason else ''
    return f'cell {event.state}{reason}'


def _round(event: e.RoundBegun) -> str:
    return _section(event, f'  {", ".join(event.tasks)} once more (round {event.n + 1})')


def _job(event: e.JobQueued | e.JobCompleted | e.JobAborted) -> str:
    return f'{event.job} {event.event.split(".")[1]}'


def _failed(event: e.TaskFailed) -> str:
    why = why_words(event.reason, event.message, event.controller_said, event.topic_says)
    return f'{_place(event)}{event.task} failed: {why}'


_LINES: Mapping[type[e.Event], Callable[..., str]] = {
    e.TaskFailed: _failed,
    e.TaskSkipped: lambda event: f'{_place(event)}{event.task} skipped: {event.reason}',
    e.TaskMarkedDone: lambda event: f'{_place(event)}{event.task} marked done',
    e.RoundBegun: _round,
    e.ItemRejected: lambda event: f'item        {event.item} rejected: {event.reason}',
    e.ItemNonconforming: lambda event: f'item        {event.item} nonconforming: {event.reason}',
    e.ItemIdentified: lambda event: f'item        {event.item} is {event.serial}',
    e.ItemRemoved: lambda event: _section(event, f' {event.how.replace("_", " ")}'),
    e.HoldRaised: lambda event: f'HOLD {event.hold}: {hold_words(event)}',
    e.ComponentOutOfService: lambda event: f'{event.component} is out of service ({event.reason})',
    e.ComponentInService: lambda event: f'{event.component} is in service',
    e.ScriptReleased: lambda event: f'script {event.digest} is released ({event.reason})',
    e.CellStateChanged: _cell_state,
    **dict.fromkeys((e.JobQueued, e.JobCompleted, e.JobAborted), _job),
}
"""The sentence of an event that needs none before it."""
