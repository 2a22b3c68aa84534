"""The real run of a job, beside its forecast: the differences, and the use of the time."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from bt_orchestrator.model import events as e
from bt_orchestrator.model.jobs.counting import MISSING, PACKED
from bt_orchestrator.model.task_spans import TaskSpan, TaskSpans
from bt_orchestrator.view.report.account.fold import AccountFold, Times
from bt_orchestrator.view.report.account.losses import WORDS, Loss
from bt_orchestrator.view.report.account.planned import US, us_of
from bt_orchestrator.view.report.account.steady_time import SteadyTime
from bt_orchestrator.view.report.account.words import is_seen


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


LEAST_S, LEAST_SHARE = 1.0, 0.01
"""A task deviates if it ends earlier or later by this time, and by this share of the forecast."""

PRODUCTION = 'production'


class Pair(NamedTuple):
    """A figure by the forecast, and as it was."""

    what: str
    forecast: int
    real: int

    @property
    def more(self) -> int:
        """By how much it really was more."""
        return self.real - self.forecast


class TaskPair(NamedTuple):
    """All attempts of a task of a component that succeeded in the forecast and really."""

    component: str
    name: str
    """Task constant."""
    times: int
    forecast_us: int
    real_us: int

    @property
    def more_us(self) -> int:
        """How much longer they really took."""
        return self.real_us - self.forecast_us


class Deviation(NamedTuple):
    """An attempt that went otherwise than it was forecast."""

    real: Work
    forecast: Work | None
    """None: it is not in the forecast."""

    @property
    def late_us(self) -> int | None:
        """By how much it ended late; below 0: early. None: it is not in the forecast."""
        return None if self.forecast is None else self.real.end_us - self.forecast.end_us


@dataclass(frozen=True)
class Retrospect:
    """A job beside its forecast, both from the same moment on."""

    job: str
    begin_us: int
    first_seq: int
    """The event from which on everything is forecast."""
    forecast: Course
    real: Course
    usual: bool
    """Tasks of the forecast take as long as they had taken before; else as the cell file says."""
    cell_differs: bool
    """The node ran with another cell file than the one of the forecast."""
    steady: SteadyTime = field(default_factory=SteadyTime, compare=False)
    """Its moments are of this time, which goes on as the clock did when the job started."""

    @property
    def late_us(self) -> int | None:
        """By how much the job ended later than forecast; None: it runs."""
        if self.real.end_us is None or self.forecast.end_us is None:
            return None
        return self.real.end_us - self.forecast.end_us

    @property
    def total(self) -> Pair:
        """The time that is compared: that of the whole job, or so far."""
        ends = self.forecast.until_us, self.real.until_us
        return Pair('all', *(end - self.begin_us for end in ends))

    def times(self) -> Iterator[Pair]:
        """Yield where the time went; the differences add up to that of the total."""
        runs = self.forecast.times, self.real.times
        yield Pair(PRODUCTION, *(times.producing_us for times in runs))
        for loss in Loss:
            pair = Pair(loss.value, *(times.lost_us.get(loss, 0) for times in runs))
            if pair.forecast or pair.real:
                yield pair

    def items(self) -> Iterator[Pair]:
        """Yield how many items left the line, by how."""
        runs = self.forecast.items, self.real.items
        for how in dict.fromkeys([PACKED, *sorted({*runs[0], *runs[1]})]):
            yield Pair(how, *(items.get(how, 0) for items in runs))

    def busy(self) -> Iterator[Pair]:
        """Yield how long each component worked; those with the largest differences first."""
        runs = self.forecast.busy_us, self.real.busy_us
        pairs = [
            Pair(name, *(run.get(name, 0) for run in runs)) for name in {**runs[0], **runs[1]}
        ]
        yield from sorted(pairs, key=lambda pair: (-abs(pair.more), pair.what))

    def tasks(self) -> Iterator[TaskPair]:
        """Yield the tasks that took longer or shorter; the largest sums first."""
        kinds: Mapping[tuple[str, str], list[int]] = defaultdict(lambda: [0, 0, 0])
        for key, real in self.real.works.items():
            forecast = self.forecast.works.get(key)
            if forecast is not None and not (real.reason or forecast.reason):
                sums = kinds[real.component, real.name]
                sums[0] += 1
                sums[1] += forecast.took_us
                sums[2] += real.took_us
        pairs = [TaskPair(*kind, *sums) for kind, sums in kinds.items()]
        pairs.sort(key=lambda pair: (-abs(pair.more_us), pair[:2]))
        yield from (pair for pair in pairs if is_seen(pair.more_us))

    def first_deviation(self) -> Deviation | None:
        """Return the first attempt that failed, was not forecast, or ended early or late."""
        return next((pair for pair in self._pairs() if self._deviates(pair)), None)

    def worst_deviation(self) -> Deviation | None:
        """Return the attempt that ended earliest or latest against its forecast."""
        known = [
            (abs(deviation.late_us), deviation)
            for deviation in self._pairs()
            if deviation.late_us is not None
        ]
        late_us, worst = max(known, key=lambda pair: pair[0], default=(0, None))
        return worst if late_us >= self._least_us() else None

    def _pairs(self) -> Iterator[Deviation]:
        for key, real in self.real.works.items():
            yield Deviation(real, self.forecast.works.get(key))

    def _deviates(self, deviation: Deviation) -> bool:
        if deviation.forecast is None or deviation.late_us is None:
            return True
        return bool(deviation.real.reason and not deviation.forecast.reason) or (
            abs(deviation.late_us) >= self._least_us()
        )

    def _least_us(self) -> float:
        end_us = self.forecast.end_us or self.forecast.until_us
        return max(LEAST_S * US, LEAST_SHARE * (end_us - self.begin_us))


def title_of(what: str) -> str:
    """Return a part of the time for people."""
    return what if what == PRODUCTION else WORDS[Loss(what)].title
