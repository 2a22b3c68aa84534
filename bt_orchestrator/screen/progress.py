"""Progress of a line in plain lines, one a step that a person would want to see."""

from __future__ import annotations

from collections.abc import Iterator

from bt_orchestrator.model import events as e
from bt_orchestrator.model.hold_words import hold_words, why_words
from bt_orchestrator.report.task_spans import TaskSpan, TaskSpans


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
        for line in self._lines(event):
            yield f'{event.time - self._start:7.2f} s  {line}'

    def _lines(self, event: e.Event) -> Iterator[str]:
        span = self._spans.follow(event)
        if span is not None and isinstance(event, e.TaskSucceeded):
            yield _succeeded(span)
        elif isinstance(event, e.TaskFailed):
            why = why_words(event.reason, event.message)
            yield f'{_place(event)}{event.task} failed: {why}'
        elif isinstance(event, e.TaskSkipped):
            yield f'{_place(event)}{event.task} skipped: {event.reason}'
        elif isinstance(event, e.TaskMarkedDone):
            yield f'{_place(event)}{event.task} marked done'
        elif isinstance(event, e.RoundBegun):
            what = f'{", ".join(event.tasks)} once more (round {event.n + 1})'
            yield f'section {event.section:<3} {event.item}  {what}'
        elif isinstance(event, e.ItemRejected):
            yield f'item        {event.item} rejected: {event.reason}'
        elif isinstance(event, e.ItemNonconforming):
            yield f'item        {event.item} nonconforming: {event.reason}'
        elif isinstance(event, e.ItemIdentified):
            yield f'item        {event.item} is {event.serial}'
        elif isinstance(event, e.ItemRemoved):
            yield f'section {event.section:<3} {event.item} {event.how.replace("_", " ")}'
        elif isinstance(event, e.HoldRaised):
            yield f'HOLD {event.hold}: {hold_words(event)}'
        elif isinstance(event, e.ComponentOutOfService):
            yield f'{event.component} is out of service ({event.reason})'
        elif isinstance(event, e.ComponentInService):
            yield f'{event.component} is in service'
        elif isinstance(event, e.ScriptReleased):
            yield f'script {event.digest} is released ({event.reason})'
        elif isinstance(event, e.CellStateChanged):
            self.held = event.state == 'Held'
            reason = f' ({event.reason})' if event.reason else ''
            yield f'cell {event.state}{reason}'
        elif isinstance(event, e.JobQueued | e.JobCompleted | e.JobAborted):
            yield f'{event.job} {event.event.split(".")[1]}'


def _succeeded(span: TaskSpan) -> str:
    started = span.started
    return f'{_place(started)}{started.name} at {started.action}, {span.seconds:.2f} s'


def _place(event: e.TaskEvent) -> str:
    if event.section is not None:
        return f'section {event.section:<3} {event.item}  '
    return f'initialization {event.job}  ' if event.job else 'belt        '
