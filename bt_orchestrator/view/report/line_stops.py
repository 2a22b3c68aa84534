"""Stops of the line one by one, and the reasons that operators gave for them."""

from __future__ import annotations

import heapq
from array import array
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

from bt_orchestrator.model import events as e
from bt_orchestrator.model.failures import ABORT
from bt_orchestrator.model.jobs import job_control
from bt_orchestrator.model.packml import VERBS
from bt_orchestrator.model.packml import Cause as Command
from bt_orchestrator.model.requests import About, words_about
from bt_orchestrator.model.stop_reason import PAUSED
from bt_orchestrator.view.report.account.losses import WORDS, Loss
from bt_orchestrator.view.report.account.planned import us_of
from bt_orchestrator.view.report.account.slot import (
    LEAST_BREAKDOWN_US,
    LEAST_STOP_US,
    Slot,
    StopSpan,
)
from bt_orchestrator.view.report.account.standing import JOB_PAUSED, Cause
from bt_orchestrator.view.report.account.stops import Stop

MOST_STOPS = 200
"""Stops that an account lists one by one: the longest. Of all others number and time."""


class GivenReason(NamedTuple):
    """The reason of a stop, as somebody gave it."""

    code: str
    seq: int = 0
    """Of the event that says so; 0: it was given before the stop, with what caused it."""
    time_us: int = 0
    who: str = ''
    role: str = ''
    why: str = ''
    """The words that came with it."""

    @classmethod
    def of(cls, event: e.OperatorDecided) -> GivenReason:
        """Return the reason that a decision gives."""
        return cls(event.code, event.seq, us_of(event.time), event.who, event.role, event.reason)


@dataclass
class GivenReasons:
    """Takes in one decision after another; knows the reason of each stop. The last one counts."""

    of_stops: dict[int, GivenReason] = field(default_factory=dict)
    """Of stops that were classified, by the number in their name."""
    of_holds: dict[str, GivenReason] = field(default_factory=dict)
    """Of the answers to holds."""

    def follow(self, event: e.Event) -> None:
        """Take in the next event."""
        if isinstance(event, e.OperatorDecided) and gives_later(event):
            if event.stop is not None:
                self.of_stops[number_of(event.stop)] = GivenReason.of(event)
            elif event.hold is not None:
                self.of_holds[event.hold] = GivenReason.of(event)

    def of(self, span: StopSpan) -> GivenReason | None:
        """Return the reason of a stop; None: it is not classified."""
        reason = self.of_stops.get(span.seq) or self.of_holds.get(span.hold)
        return reason or (GivenReason(span.code) if span.code else None)


def gives_later(event: e.OperatorDecided) -> bool:
    """Tell whether a decision says the reason of a stop that has begun before."""
    return bool(event.code) and (event.stop is not None or event.hold is not None)


def number_of(name: str) -> int:
    """Return the number of the event with which a stop began."""
    return int(name.rpartition(':')[2])


class LineStop(NamedTuple):
    """One stop of the line, as far as it is in planned time."""

    span: StopSpan
    us: int
    """Planned time of it."""
    reason: GivenReason | None
    """None: it is not classified."""

    @property
    def about(self) -> str:
        """Its loss and its cause, in words."""
        span = self.span
        summed = Stop(span.loss, span.detail, span.component, 1, self.us)
        return ', '.join(filter(None, (WORDS[span.loss].title, summed.about)))


class ReasonSum(NamedTuple):
    """All stops of one reason, and of one loss and cause among them."""

    code: str
    """Empty: not classified."""
    loss: Loss
    detail: str
    component: str
    times: int
    us: int


class SpanTotal:
    """Takes in the stops of one slot after another, and adds them up by their reasons."""

    def __init__(self, reasons: GivenReasons) -> None:
        self._reasons = reasons
        self._open: StopSpan | None = None
        """The last one, which may go on."""
        self._us = 0
        """Planned time of it so far."""
        self._sums: dict[tuple[str, Loss, str, str], list[int]] = {}
        self._longest: list[tuple[int, int, LineStop]] = []
        self._faults: dict[str, array[int]] = {}
        """By component, the time of each own fault that may be a breakdown."""

    def add(self, slot: Slot, *, is_planned: bool) -> None:
        """Take in the stops of the next slot."""
        for span in slot.spans:
            if self._open is None or self._open.seq != span.seq:
                self._close()
                self._open, self._us = replace(span), 0
            self._open.until_us = span.until_us
            self._open.code = span.code or self._open.code
            if is_planned:
                self._us += span.until_us - max(span.since_us, slot.begin_us)

    def _close(self) -> None:
        span, us, self._open = self._open, self._us, None
        if span is None or not us or span.long_us < LEAST_STOP_US:
            return
        stop = LineStop(span, us, self._reasons.of(span))
        code = '' if stop.reason is None else stop.reason.code
        key = (code, span.loss, span.detail, span.component)
        known = self._sums.setdefault(key, [0, 0])
        known[0] += 1
        known[1] += us
        if span.loss is Loss.OWN_FAULT and us >= LEAST_BREAKDOWN_US:
            self._faults.setdefault(span.component, array('q')).append(us)
        entry = (us, -span.seq, stop)
        if len(self._longest) < MOST_STOPS:
            heapq.heappush(self._longest, entry)
        else:
            heapq.heappushpop(self._longest, entry)

    def stops(
        self,
    ) -> tuple[tuple[LineStop, ...], tuple[ReasonSum, ...], Mapping[str, Sequence[int]]]:
        """Return the longest in their order, all sums, and the long own faults by component.

        No further slot is taken in after that.
        """
        self._close()
        stops = sorted(
            (stop for _, _, stop in self._longest), key=lambda record: record.span.since_us
        )
        sums = (ReasonSum(*key, times, us) for key, (times, us) in self._sums.items())
        by_reason = tuple(
            sorted(sums, key=lambda record: (-record.us, record.code, record.detail))
        )
        faults = {
            name: tuple(sorted(lengths_us)) for name, lengths_us in sorted(self._faults.items())
        }
        return tuple(stops), by_reason, faults


class ReasonShare(NamedTuple):
    """A line of the Pareto of reasons."""

    code: str
    """Empty: not classified."""
    times: int
    us: int


def shares(sums: Iterable[ReasonSum]) -> tuple[ReasonShare, ...]:
    """Return the time of each reason, the longest first."""
    known: dict[str, list[int]] = {}
    for reason in sums:
        total = known.setdefault(reason.code, [0, 0])
        total[0] += reason.times
        total[1] += reason.us
    reasons = (ReasonShare(code, times, us) for code, (times, us) in known.items())
    return tuple(sorted(reasons, key=lambda share: (-share.us, share.code)))


# Reasons that are given before a stop begins, or while it lasts.

_PAUSE, _STOP = VERBS[Command.HOLD], VERBS[Command.STOP]
_GO_ON = {VERBS[Command.START], VERBS[Command.CLEAR]}
_CELL, _EMERGENCY, _JOB = 'cell', 'emergency', 'job'


class CodesGiven:
    """Takes in one event after another; knows the code that came with what stops the line."""

    def __init__(self) -> None:
        self._codes: dict[str, str] = {}
        self._of_pause = ''
        """Of a pause whose hold comes next."""

    def follow(self, event: e.Event) -> None:
        """Take in the next event."""
        if isinstance(event, e.OperatorDecided):
            self._decided(event)
        elif isinstance(event, e.HoldRaised):
            if self._of_pause and event.reason == PAUSED:
                self._codes[_of_hold(event.hold)] = self._of_pause
            self._of_pause = ''
        elif isinstance(event, e.HoldReleased):
            self._codes.pop(_of_hold(event.hold), None)

    def _decided(self, event: e.OperatorDecided) -> None:
        answer = event.answer
        self._of_pause = ''
        if event.component is not None:
            if answer in words_about(About.COMPONENT):
                self._set(_of_component(event.component), event.code)
        elif event.job is not None:
            if answer == job_control.PAUSE.verb:
                self._set(_JOB, event.code)
        elif event.hold is None and event.stop is None:
            if answer == _PAUSE:
                self._of_pause = event.code
            elif answer == _STOP:
                self._set(_CELL, event.code)
            elif answer == ABORT:
                self._set(_EMERGENCY, event.code)
            elif answer in _GO_ON:
                self._codes.pop(_CELL, None)
                self._codes.pop(_EMERGENCY, None)

    def _set(self, key: str, code: str) -> None:
        if code:
            self._codes[key] = code
        else:
            self._codes.pop(key, None)

    def of(self, cause: Cause | None) -> str:
        """Return the code of the present loss; empty: none was given."""
        if cause is None or not self._codes:
            return ''
        if cause.hold:
            key = _of_hold(cause.hold)
        elif cause.loss is Loss.EMERGENCY:
            key = _EMERGENCY
        elif cause.loss is Loss.OPERATOR:
            key = _JOB if cause.detail == JOB_PAUSED else _CELL
        else:
            key = _of_component(cause.component) if cause.loss is Loss.WAITING else ''
        return self._codes.get(key, '')

    def plain(self) -> dict[str, str]:
        """Return what it knows, as JSON carries it."""
        return {**self._codes, '': self._of_pause}

    def go_on_from(self, plain: Mapping[str, Any]) -> None:
        """Know what another one knew."""
        self._codes = {key: code for key, code in plain.items() if key}
        self._of_pause = plain.get('', '')


def _of_hold(hold: str) -> str:
    return f'hold {hold}'


def _of_component(component: str) -> str:
    return f'component {component}'
