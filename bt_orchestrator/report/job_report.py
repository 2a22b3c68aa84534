"""What became of one job and its items: a fold over its events."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from bt_orchestrator.model import events as e
from bt_orchestrator.model.cell import OnFailure

ON_THE_LINE = 'on_the_line'


@dataclass
class ItemReport:
    """One item of a job."""

    id: str
    outcome: str = ON_THE_LINE
    """packed, rejected, by_hand, missing, or on_the_line."""
    nonconforming: list[str] = field(default_factory=list)
    """Tasks that failed and were continued."""
    results: dict[str, Mapping[str, Any]] = field(default_factory=dict)
    """By task."""


@dataclass
class JobReport:
    """One job, from when it was queued."""

    job: str
    exit_status: str = ''
    """completed, stopped, aborted or removed; empty: it has not ended."""
    reason: str = ''
    items: dict[str, ItemReport] = field(default_factory=dict)
    failures: list[e.TaskFailed] = field(default_factory=list)

    def follow(self, event: e.Event) -> None:
        """Take in the next event, whatever it is about."""
        if getattr(event, 'job', None) != self.job:
            return
        if isinstance(event, e.CycleStarted):
            self.items.setdefault(event.item, ItemReport(event.item))
        elif isinstance(event, e.TaskEvent):
            self._task(event)
        elif isinstance(event, e.ItemRemoved):
            self.items[event.item].outcome = event.how
        elif isinstance(event, e.ItemMissing):
            self.items[event.item].outcome = 'missing'
        elif isinstance(event, e.JobCompleted | e.JobAborted):
            self.exit_status, self.reason = event.exit_status, event.reason
        elif isinstance(event, e.JobRemoved):
            self.exit_status = 'removed'

    def _task(self, event: e.TaskEvent) -> None:
        if isinstance(event, e.TaskFailed):
            self.failures.append(event)
        if event.item is None:
            return
        item = self.items[event.item]
        if isinstance(event, (e.TaskSucceeded, e.TaskMarkedDone)) and event.results:
            item.results[event.task] = event.results
        elif isinstance(event, e.TaskContinued) and event.policy == OnFailure.CONTINUE.value:
            item.nonconforming.append(event.task)
