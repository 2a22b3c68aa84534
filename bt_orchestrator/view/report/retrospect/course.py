"""How a job went, by the events of a run, real or virtual: ends, times of components, losses."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from bt_orchestrator.model import events as e
from bt_orchestrator.model.jobs.counting import MISSING
from bt_orchestrator.model.task_spans import TaskSpan, TaskSpans
from bt_orchestrator.view.report.account.fold import AccountFold, Times
from bt_orchestrator.view.report.account.planned import us_of


class WorkKey(NamedTuple):
    """The attempt of a task of an item."""

    task: e.TaskKey
    round: int
    attempt: int


@dataclass(frozen=True)
class Work:
    """One attempt of a task of the job that ended."""

    key: WorkKey
    name: str
    """Task constant."""
    component: str
    start_us: int
    end_us: int
    reason: str
    """Why it failed; empty: it succeeded."""

    @property
    def took_us(self) -> int:
        """How long it took; 0 if the clock was set back meanwhile."""
        return max(0, self.end_us - self.start_us)


@dataclass(frozen=True)
class Course:
    """How a job went, up to its end or to the moment up to which it is compared."""

    until_us: int
    """Up to when times and items are counted."""
    end_us: int | None
    """When the job ended; None: it did not, as far as is known."""
    times: Times
    items: Mapping[str, int]
    """Items that left the line, by how."""
    busy_us: Mapping[str, int]
    """How long each component worked for the job, the belt for every move; by component."""
    works: Mapping[WorkKey, Work]
    """In the order in which they ended."""


class CourseFold:
    """Takes in events, some of before the job starts among them. Implements `ports.EventSink`."""

    def __init__(
        self, job: str, begin_us: int, account: AccountFold, until_us: float = math.inf
    ) -> None:
        """Begin.

        :param begin_us: when the job starts
        :param account: that has taken in every event before that
        :param until_us: later events tell only of attempts, and of the end of the job
        """
        self._job = job
        self._begin = begin_us
        self._until = until_us
        self._account = account
        self._spans = TaskSpans()
        self._items: Counter[str] = Counter()
        self._busy: Counter[str] = Counter()
        self._works: dict[WorkKey, Work] = {}
        self._end: int | None = None

    def publish(self, events: Sequence[e.Event]) -> None:
        """Take in the next events."""
        for event in events:
            self.follow(event)

    def before(self, event: e.Event) -> None:
        """Take in an event before the start of the job: what is at work then."""
        self._spans.follow(event)

    def follow(self, event: e.Event) -> None:
        """Take in the next event; what comes after the end of the job changes nothing."""
        if self._end is not None:
            return
        now, span = us_of(event.time), self._spans.follow(event)
        if span is not None:
            self._worked(span)
        if now <= self._until:
            self._account.follow(event)
            self._item(event)
        if isinstance(event, (e.JobCompleted, e.JobAborted)) and event.job == self._job:
            self._end = now

    def course(self, until_us: int) -> Course:
        """Return how it went.

        :param until_us: the last moment that is known, if the job has not ended
        """
        end = until_us if self._end is None else self._end
        until = min(end, self._until, until_us)
        for begun in self._spans.open():
            self._book(begun, until)
        times = self._account.until(int(until))
        return Course(int(until), self._end, times, self._items, self._busy, self._works)

    def _worked(self, span: TaskSpan) -> None:
        begun, ended = span
        end = us_of(ended.time)
        self._book(begun, end)
        if begun.job == self._job:
            key = WorkKey(begun.key, begun.round, begun.attempt)
            reason = ended.reason if isinstance(ended, e.TaskFailed) else ''
            start = us_of(begun.time)
            self._works[key] = Work(key, begun.name, begun.component, start, end, reason)

    def _book(self, begun: e.TaskStarted, end: float) -> None:
        """Book the time of an attempt that is in the time of the job."""
        if begun.job in (self._job, None):
            us = min(end, self._until) - max(us_of(begun.time), self._begin)
            self._busy[begun.component] += max(0, int(us))

    def _item(self, event: e.Event) -> None:
        if isinstance(event, e.ItemRemoved) and event.job == self._job:
            self._items[event.how] += 1
        elif isinstance(event, e.ItemMissing) and event.job == self._job:
            self._items[MISSING] += 1
