"""Since when a task takes longer, or less long: where its durations split best into two levels."""

from __future__ import annotations

import statistics
from collections.abc import Iterable, Sequence
from datetime import datetime
from typing import NamedTuple

from bt_orchestrator.view.report.durations.times import Buckets, Samples

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
    medians = [(statistics.median(one.seconds), len(one.seconds)) for _, one in known]
    splits = range(1, len(known))
    if not splits:
        return None
    at = min(splits, key=lambda place: _spread(medians[:place]) + _spread(medians[place:]))
    before = _all(one for _, one in known[:at])
    after = _all(one for _, one in known[at:])
    found = Drift(known[at][0], statistics.median(before), statistics.median(after))
    return found if _is_certain(found, before, after) else None


def _all(samples: Iterable[Samples]) -> Sequence[float]:
    return [seconds for one in samples for seconds in one.seconds]


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


def _is_certain(found: Drift, before: Sequence[float], after: Sequence[float]) -> bool:
    if min(len(before), len(after)) < LEAST_SAMPLES:
        return False
    change = abs(found.after_s - found.before_s)
    errors = _error(before, found.before_s) ** 2 + _error(after, found.after_s) ** 2
    return (
        change >= LEAST_CHANGE_S
        and change >= LEAST_CHANGE * found.before_s
        and change >= CERTAINTY * errors**0.5
    )


def _error(seconds: Sequence[float], level: float) -> float:
    """Return the standard error of a median."""
    deviation = statistics.median(abs(one - level) for one in seconds)
    return float(_ERROR_OF_MEDIAN * deviation / len(seconds) ** 0.5)
