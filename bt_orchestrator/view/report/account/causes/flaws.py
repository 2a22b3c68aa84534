"""Causes of scrap and rework, and measured values beside the bounds of verdicts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from typing import Any

from bt_orchestrator.model.codec import to_plain
from bt_orchestrator.model.jobs.counting import BY_HAND, NONCONFORMING, REJECTED
from bt_orchestrator.view.report.account.words import UNKNOWN


class Effect(Enum):
    """The effect of something that went wrong with an item."""

    NONCONFORMING = NONCONFORMING
    REJECTED = REJECTED
    BY_HAND = BY_HAND
    ROUND = 'round'
    """The tasks of a repeat were done once more."""
    ATTEMPT = 'attempt'
    """A task was done once more."""

    @property
    def is_scrap(self) -> bool:
        """Tell whether the item is not good."""
        return self not in (Effect.ROUND, Effect.ATTEMPT)


class Decision(Enum):
    """The decision that had the effect: of the script, or of a person."""

    ON_FAILURE = 'on_failure'
    RETRIES = 'retries'
    REPEAT = 'repeat'
    REJECT = 'reject'
    MARK_DONE = 'mark_done'
    SKIP = 'skip'
    RETRY = 'retry'
    AGAIN = 'again'
    TAKEN_OFF = 'remove_item'
    ABORT_JOB = 'abort_job'


BY_SCRIPT = (Decision.ON_FAILURE, Decision.RETRIES, Decision.REPEAT)


@dataclass(frozen=True)
class Flaw:
    """A cause of scrap or rework."""

    effect: Effect
    decision: Decision
    product: str = ''
    task: str = ''
    """Id of the task that failed; empty: none did."""
    component: str = ''
    """Of that attempt; empty: nothing was sent."""
    reason: str = ''
    """Of that attempt."""
    bound: str = ''
    """Comparisons of the task's verdict that the result did not meet."""

    @property
    def order(self) -> tuple[str, ...]:
        """Where it stands among equally frequent ones."""
        about = (self.product, self.task, self.component, self.reason, self.bound)
        return (self.effect.value, *about, self.decision.value)


@dataclass
class FlawSum:
    """Equal causes."""

    of: Flaw
    times: int = 0


@dataclass(frozen=True)
class Bounds:
    """A measured value that a verdict compares with bounds."""

    product: str
    task: str
    component: str
    value: str
    """Field of the result."""
    at_least: float | None = None
    at_most: float | None = None

    @property
    def order(self) -> tuple[str, ...]:
        """Where it stands among others."""
        about = (self.product, self.task, self.component, self.value)
        return (*about, str(self.at_least), str(self.at_most))


@dataclass
class MeasuredSum:
    """The measured values between some bounds, and beyond them."""

    of: Bounds
    least: float
    greatest: float
    times: int = 0
    below: int = 0
    above: int = 0
    numerator: int = 0
    """Of the sum of all, as an exact fraction."""
    denominator: int = 1

    @property
    def mean(self) -> Fraction:
        """The arithmetic mean."""
        return Fraction(self.numerator, self.denominator * self.times)

    def measured(self, value: float) -> None:
        """Take in a value."""
        low, high = self.of.at_least, self.of.at_most
        below, above = low is not None and value < low, high is not None and value > high
        numerator, denominator = value.as_integer_ratio()
        self.add(MeasuredSum(self.of, value, value, 1, below, above, numerator, denominator))

    def add(self, more: MeasuredSum) -> None:
        """Take in values of the same kind."""
        self.least, self.greatest = min(self.least, more.least), max(self.greatest, more.greatest)
        self.times += more.times
        self.below += more.below
        self.above += more.above
        whole = max(self.denominator, more.denominator)  # of floats all are powers of two
        self.numerator = self.numerator * (whole // self.denominator) + more.numerator * (
            whole // more.denominator
        )
        self.denominator = whole


# Both in words, and as plain data.

EFFECTS: Mapping[Effect, str] = {
    Effect.NONCONFORMING: 'nonconforming',
    Effect.REJECTED: 'rejected',
    Effect.BY_HAND: 'taken off by hand',
    Effect.ROUND: 'rework round',
    Effect.ATTEMPT: 'further attempt',
}

DECISIONS: Mapping[Decision, str] = {
    Decision.ON_FAILURE: 'by the script',
    Decision.RETRIES: 'by the script',
    Decision.REPEAT: 'by the script',
    Decision.REJECT: 'answer reject',
    Decision.MARK_DONE: 'answer mark_done',
    Decision.SKIP: 'answer skip',
    Decision.RETRY: 'answer retry',
    Decision.AGAIN: 'answer again',
    Decision.TAKEN_OFF: 'remove-item',
    Decision.ABORT_JOB: 'abort_job',
}

MEASURED_TITLES = ('times', 'below', 'above', 'least', 'mean', 'greatest', 'at least', 'at most')


def flaw_words(flaw: Flaw) -> str:
    """Say which task failed, why, and what was decided."""
    at = f' at {flaw.component}' if flaw.component else ''
    why = f' {flaw.reason}' if flaw.reason else ''
    bound = f' ({flaw.bound})' if flaw.bound else ''
    task = f'{flaw.task}{at}{why}{bound}' if flaw.task else ''
    return ', '.join(filter(None, (task, DECISIONS[flaw.decision])))


def measured_name(measurement: MeasuredSum) -> str:
    """Name a measured value."""
    at = f' at {measurement.of.component}' if measurement.of.component else ''
    return f'{measurement.of.task} {measurement.of.value}{at}'


def measured_texts(measurement: MeasuredSum) -> tuple[str, ...]:
    """Return the numbers about a measured value, as `MEASURED_TITLES` names them."""
    counts = (measurement.times, measurement.below, measurement.above)
    numbers = (
        measurement.least,
        float(measurement.mean),
        measurement.greatest,
        measurement.of.at_least,
        measurement.of.at_most,
    )
    return (*map(str, counts), *(UNKNOWN if n is None else f'{n:.6g}' for n in numbers))


def flaw_plain(flaw: FlawSum) -> dict[str, Any]:
    """Return a cause of scrap or rework."""
    return {**to_plain(flaw.of, whole=True), 'times': flaw.times}


def measured_plain(measurement: MeasuredSum) -> dict[str, Any]:
    """Return measured values beside their bounds."""
    return {
        **to_plain(measurement.of, whole=True),
        'times': measurement.times,
        'below': measurement.below,
        'above': measurement.above,
        'least': measurement.least,
        'mean': float(measurement.mean),
        'greatest': measurement.greatest,
    }
