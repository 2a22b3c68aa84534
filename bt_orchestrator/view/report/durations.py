"""How long tasks take against their nominal times, and since when they take longer."""

from __future__ import annotations

import statistics
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any, NamedTuple

from bt_orchestrator.base.errors import counted
from bt_orchestrator.model.cell import Cell
from bt_orchestrator.model.keeping.records import Wanted
from bt_orchestrator.view.report.account.period import Period
from bt_orchestrator.view.report.account.planned import US
from bt_orchestrator.view.report.duration_times import FOLLOWED, Buckets, Kind, Samples, TimesFold
from bt_orchestrator.view.report.reading import Reading

LATELY = timedelta(days=7)
"""Lately is this time before the end of the period."""

SHORT = timedelta(days=3)
"""In a shorter period durations are compared by the hour."""

LEAST_FOR_PROPOSAL = 10
"""Times that a task was done for a new nominal time."""


@dataclass(frozen=True)
class TaskTimes:
    """One task of a component."""

    kind: Kind
    count: int
    """Times that it succeeded in the period."""
    nominal_s: float | None
    """By the cell file; None: it was not given, or does not have the component."""
    lately_s: float | None
    """Median of the last seven days of the period; None: it was not done then."""
    drift: Drift | None

    @property
    def now_s(self) -> float | None:
        """How long it takes since its last change."""
        return self.lately_s if self.drift is None else self.drift.after_s

    @property
    def change(self) -> float | None:
        """By which part it is slower than nominal; negative: faster. None: not known."""
        if not self.nominal_s or self.now_s is None:
            return None
        return self.now_s / self.nominal_s - 1.0

    @property
    def proposed_s(self) -> float | None:
        """A better nominal time; None: the present one is good, or it was done too few times."""
        if self.nominal_s is None or self.now_s is None or self.count < LEAST_FOR_PROPOSAL:
            return None
        difference = abs(self.now_s - self.nominal_s)
        if difference < max(LEAST_CHANGE_S, LEAST_CHANGE * self.nominal_s):
            return None
        return round(self.now_s, 2 if self.now_s < 10 else 1)


@dataclass(frozen=True)
class Durations:
    """All tasks, those first that differ most from their nominal times."""

    tasks: Sequence[TaskTimes]
    by_hour: bool


def durations(reading: Reading, period: Period, cell: Cell | None) -> Durations:
    """Read how long tasks took in a period."""
    begin, end = (us / US for us in period.on_clock)
    by_hour = end - begin < SHORT.total_seconds()
    fold = TimesFold(period.zone, by_hour=by_hour)
    for event in reading.events(Wanted(since=begin, until=end + 0.5 / US, events=FOLLOWED)):
        fold.follow(event)
    since = datetime.fromtimestamp(end, period.zone) - LATELY
    tasks = [_task(kind, buckets, cell, since) for kind, buckets in fold.kinds.items()]
    tasks.sort(key=lambda task: (-abs(task.change or 0.0), task.kind))
    return Durations(tasks, by_hour)


def _task(kind: Kind, buckets: Buckets, cell: Cell | None, since: datetime) -> TaskTimes:
    component = cell.components.get(kind.component) if cell is not None else None
    nominal = None if component is None else component.duration_s(kind.name)
    lately = [s for begin, bucket in buckets.items() if begin >= since for s in bucket.seconds]
    return TaskTimes(
        kind,
        sum(bucket.count for bucket in buckets.values()),
        nominal,
        statistics.median(lately) if lately else None,
        drift_of(buckets),
    )


def proposals(times: Durations, cell: Cell) -> Mapping[str, Mapping[str, float]]:
    """Return new nominal times, by component and task constant.

    Of the belt only its move: the cell file has one time for all its tasks.
    """
    new: dict[str, dict[str, float]] = {}
    conveyor = cell.conveyor
    for task in times.tasks:
        of_belt = task.kind.component == conveyor.component.name
        if task.proposed_s is not None and (not of_belt or task.kind.name == conveyor.task):
            new.setdefault(task.kind.component, {})[task.kind.name] = task.proposed_s
    return new


# --- as text and as data ------------------------------------------------------------------------


def sentence(task: TaskTimes, times: Durations) -> str:
    """Say of one task how long it takes, against nominal, and since when."""
    parts = [] if task.nominal_s is None else [f'{task.nominal_s:g} s nominal']
    if task.lately_s is None:
        parts.append('not done in the last 7 days')
    else:
        parts.append(f'{_s(task.lately_s)} {"lately" if times.by_hour else "in the last 7 days"}')
    if task.drift is not None:
        was = f'{_s(task.drift.before_s)} before and {_s(task.drift.after_s)} since'
        parts.append(f'{task.drift.word} since {_when(task.drift.since, times)} ({was})')
    elif task.change is not None and abs(task.change) >= LEAST_CHANGE:
        word = 'slower' if task.change > 0 else 'faster'
        parts.append(f'{abs(task.change):.0%} {word} than nominal all the time')
    return f'{task.kind}: {", ".join(parts)}'


def lines(times: Durations) -> Iterator[str]:
    """Yield the durations as text."""
    if not times.tasks:
        yield 'no task succeeded in this time: there are no durations'
    for task in times.tasks:
        yield f'{sentence(task, times)}; done {counted(task.count, "time")}'


def plain(times: Durations) -> list[dict[str, Any]]:
    """Return the durations as data that JSON can carry."""
    return [
        {
            'component': task.kind.component,
            'task': task.kind.name,
            'count': task.count,
            'nominal_s': task.nominal_s,
            'lately_s': task.lately_s,
            'now_s': task.now_s,
            'proposed_s': task.proposed_s,
            'drift': None
            if task.drift is None
            else {
                'since': task.drift.since.astimezone().isoformat(),
                'before_s': task.drift.before_s,
                'after_s': task.drift.after_s,
            },
        }
        for task in times.tasks
    ]


def _s(seconds: float) -> str:
    return f'{seconds:.3g} s' if seconds < 1000 else f'{seconds:.0f} s'


def _when(since: datetime, times: Durations) -> str:
    return f'{since:%A} {since:%H:%M}' if times.by_hour else f'{since:%A, %Y-%m-%d}'


# Since when a task takes longer, or less long: where its durations split best into two levels.

LEAST_CHANGE = 0.05
"""Less than this part is no drift."""

LEAST_CHANGE_S = 0.02
"""Nor is less than this: it may be the network."""

LEAST_SAMPLES = 5
"""Durations that are needed on each side."""

CERTAINTY = 4.0
"""By how many standard errors of the two medians they have to differ."""

MOST_BUCKETS = 90
"""The last days or hours that are looked at."""

_ERROR_OF_MEDIAN = 1.2533 * 1.4826
"""Standard error of a median by the median deviation, times the root of the number."""


class Drift(NamedTuple):
    """A lasting change."""

    since: datetime
    """Beginning of the first day, or hour, with the new level."""
    before_s: float
    after_s: float

    @property
    def word(self) -> str:
        """Name its direction."""
        return 'slower' if self.after_s > self.before_s else 'faster'


def drift_of(buckets: Buckets) -> Drift | None:
    """Return the change that splits the durations best; None: there is none that is certain.

    One level before and one after, each a median: the split with the least sum of deviations.
    """
    known = list(buckets.items())[-MOST_BUCKETS:]
    medians = [(statistics.median(bucket.seconds), len(bucket.seconds)) for _, bucket in known]
    splits = range(1, len(known))
    if not splits:
        return None
    at = min(splits, key=lambda place: _spread(medians[:place]) + _spread(medians[place:]))
    before = _all(bucket for _, bucket in known[:at])
    after = _all(bucket for _, bucket in known[at:])
    drift = Drift(known[at][0], statistics.median(before), statistics.median(after))
    return drift if _is_certain(drift, before, after) else None


def _all(samples: Iterable[Samples]) -> Sequence[float]:
    return [seconds for sample in samples for seconds in sample.seconds]


def _spread(medians: Sequence[tuple[float, int]]) -> float:
    """Return the sum of the deviations from the weighted median."""
    ordered = sorted(medians)
    half, reached = sum(number for _, number in ordered) / 2, 0
    level = ordered[-1][0]
    for seconds, number in ordered:
        reached += number
        if reached >= half:
            level = seconds
            break
    return sum(abs(seconds - level) * number for seconds, number in ordered)


def _is_certain(drift: Drift, before: Sequence[float], after: Sequence[float]) -> bool:
    if min(len(before), len(after)) < LEAST_SAMPLES:
        return False
    change = abs(drift.after_s - drift.before_s)
    errors = _error(before, drift.before_s) ** 2 + _error(after, drift.after_s) ** 2
    return (
        change >= LEAST_CHANGE_S
        and change >= LEAST_CHANGE * drift.before_s
        and change >= CERTAINTY * errors**0.5
    )


def _error(seconds: Sequence[float], level: float) -> float:
    """Return the standard error of a median."""
    deviation = statistics.median(abs(sample - level) for sample in seconds)
    return float(_ERROR_OF_MEDIAN * deviation / len(seconds) ** 0.5)
