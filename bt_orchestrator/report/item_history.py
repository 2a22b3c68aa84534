"""The record of one item: every attempt for it, how each ended, and what people decided."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from bt_orchestrator.model import events as e
from bt_orchestrator.model.hold_words import why_words
from bt_orchestrator.report.task_spans import TaskSpans

RUNNING, SUCCEEDED, FAILED = 'running', 'succeeded', 'failed'
SKIPPED, MARKED_DONE, CONTINUED = 'skipped', 'marked_done', 'continued'
"""Outcomes; the last three are of a task and no attempt."""

FOLLOWED = ('task.', 'item.', 'cycle.started', 'hold.raised', 'job.queued', 'job.updated')
"""Events of its job that the record of an item needs; decisions name only a hold, or the item."""


@dataclass
class Attempt:
    """One attempt of a task, or what was decided instead of one."""

    section: int | None
    task: str
    outcome: str
    name: str = ''
    """Task constant; empty: nothing was sent."""
    component: str = ''
    round: int = 0
    """Which further round of its repeat, from 1; 0: the first pass, or no repeat."""
    attempt: int = 0
    started: float | None = None
    ended: float | None = None
    seconds: float | None = None
    reason: str = ''
    message: str = ''
    args: Mapping[str, Any] = field(default_factory=dict)
    results: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Decision:
    """What somebody decided about an item."""

    time: float
    who: str
    what: str
    reason: str
    hold: str = ''
    """The hold that was answered; empty: none."""


@dataclass
class Held:
    """A hold about an item."""

    id: str
    seq: int
    """Of the event that raised it."""
    time: float
    task: str
    words: str


@dataclass
class ItemHistory:
    """An item from its source cycle to its end."""

    item: str
    job: str
    script: str = ''
    recipe: str = ''
    recipe_version: int | None = None
    started: float | None = None
    ended: float | None = None
    how: str = ''
    """packed, rejected, by_hand or missing; empty while it is on the line."""
    rejected: str = ''
    """Why it was rejected; empty: it was not."""
    serial: str = ''
    lots: Mapping[str, str] = field(default_factory=dict)
    tasks: list[Attempt] = field(default_factory=list)
    holds: list[Held] = field(default_factory=list)
    decisions: list[Decision] = field(default_factory=list)


class ItemFold:
    """Takes in the events of a job, in order, and then the decisions about holds of its item."""

    def __init__(self, item: str, job: str) -> None:
        self.history = ItemHistory(item, job)
        self._spans = TaskSpans()
        self._open: dict[e.TaskKey, Attempt] = {}

    @property
    def is_known(self) -> bool:
        """Tell whether anything was told of the item."""
        history = self.history
        return bool(history.tasks or history.holds or history.decisions) or (
            history.started is not None or history.ended is not None
        )

    def follow(self, event: e.Event) -> None:
        """Take in the next event; those of other items change nothing."""
        history = self.history
        if isinstance(event, (e.JobQueued, e.JobUpdated)):
            if event.job == history.job:
                history.script = event.script
                history.recipe, history.recipe_version = event.recipe, event.recipe_version
        elif getattr(event, 'item', None) != history.item:
            return
        elif isinstance(event, e.TaskEvent):
            self._task(event)
        else:
            self._item(event)

    def _item(self, event: e.Event) -> None:
        history = self.history
        if isinstance(event, e.CycleStarted) and history.started is None:
            history.started = event.time
        elif isinstance(event, e.ItemMissing):
            history.ended, history.how = event.time, 'missing'
        elif isinstance(event, e.ItemRemoved):
            history.ended, history.how = event.time, event.how
        elif isinstance(event, e.ItemPlaced):
            history.lots = event.lots
        elif isinstance(event, e.ItemIdentified):
            history.serial = event.serial
        elif isinstance(event, e.ItemRejected):
            history.rejected = event.reason
        elif isinstance(event, e.HoldRaised):
            words = why_words(event.reason, event.message)
            history.holds.append(Held(event.hold, event.seq, event.time, event.task or '', words))
        elif isinstance(event, e.OperatorDecided):
            self.decided(event)

    def decided(self, event: e.OperatorDecided) -> None:
        """Take in a decision about this item, or about a hold of it."""
        self.history.decisions.append(
            Decision(event.time, event.who, event.answer, event.reason, event.hold or '')
        )

    def _task(self, event: e.TaskEvent) -> None:
        span = self._spans.follow(event)
        attempt = Attempt(event.section, event.task, RUNNING)
        if isinstance(event, e.TaskStarted):
            attempt.name, attempt.component = event.name, event.component
            attempt.round = event.round
            attempt.attempt, attempt.started, attempt.args = event.attempt, event.time, event.args
            self._open[event.key] = attempt
        elif isinstance(event, (e.TaskSucceeded, e.TaskFailed)):
            known = self._open.pop(event.key, None)
            attempt = known or attempt
            attempt.attempt, attempt.ended = event.attempt, event.time
            attempt.seconds = span.seconds if span else None
            _end(attempt, event)
            if known is not None:
                return
        elif isinstance(event, e.TaskSkipped):
            attempt.outcome, attempt.ended, attempt.reason = SKIPPED, event.time, event.reason
        elif isinstance(event, e.TaskMarkedDone):
            attempt.outcome, attempt.ended = MARKED_DONE, event.time
            attempt.results = event.results
        elif isinstance(event, e.TaskContinued):
            attempt.outcome, attempt.ended, attempt.reason = CONTINUED, event.time, event.policy
        else:
            return
        self.history.tasks.append(attempt)


def _end(attempt: Attempt, event: e.TaskSucceeded | e.TaskFailed) -> None:
    if isinstance(event, e.TaskSucceeded):
        attempt.outcome, attempt.results = SUCCEEDED, event.results
    else:
        attempt.outcome = FAILED
        attempt.reason, attempt.message = event.reason, event.message
        attempt.results = event.results
