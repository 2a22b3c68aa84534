"""The account of the shift that runs as a part of the page: numbers, and no words but names."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from bt_orchestrator.view.report.account.calendar import Turn
from bt_orchestrator.view.report.account.live import Live
from bt_orchestrator.view.report.account.planned import US


def shift_part(live: Live | None, why_not: str) -> dict[str, Any]:
    """Return the part.

    :param why_not: what it lacks; empty: nothing
    """
    if live is None or live.now.turn is None:
        return {'shift': None, 'why_not': why_not}
    account, turn = live.account, live.now.turn
    shown, period = account.figures, account.period
    return {
        'shift': turn.shift,
        'day': str(turn.day),
        'runs': live.runs,
        'begin': _s(period.shown_us(period.begin_us)),
        'end': _s(period.shown_us(live.now.period.end_us)),
        'at': _s(period.shown_us(period.end_us)),
        'next': _next(live.now.next),
        'oee': _ratio(shown.oee),
        'availability': _ratio(shown.availability),
        'performance': _ratio(shown.performance),
        'quality': _ratio(shown.quality),
        'targets': {name: _ratio(target) for name, target in period.targets.items()},
        'has_pace': shown.has_paces,
        'lack': None if shown.lack is None else shown.lack.value,
        'produced': shown.produced,
        'good': shown.good,
        'per_item_s': _s(shown.per_item_us),
        'pace_s': _s(shown.pace_us),
        'planned_s': _s(shown.times.planned.total_us),
        'losses': [
            {'loss': bar.loss.value, 'seconds': _s(bar.us)}
            for bar in shown.steps_seen()
            if bar.loss is not None
        ],
        'stopped': _stopped(live),
        'damaged': account.source.unreadable,
        'clock_set': [
            {'seconds': _s(step.by_us), 'before': _s(before), 'after': _s(after)}
            for step in account.source.steps
            for before, after in [step.times_us]
        ],
        'breaks': [
            {'begin': _s(one.begin_us), 'end': _s(one.end_us), 'usual_s': _s(one.usual_us)}
            for one in period.changed_breaks
        ],
        'why_not': why_not,
    }


def _next(turn: Turn | None) -> dict[str, Any] | None:
    return None if turn is None else {'shift': turn.shift, 'begin': _s(turn.period.begin_us)}


def _stopped(live: Live) -> dict[str, Any] | None:
    if live.stopped is None:
        return None
    cause, period = live.stopped.cause, live.account.period
    now_us = period.end_us  # ages are told by the clock of now, which may have been set
    return {
        'loss': cause.loss.value,
        'detail': cause.detail,
        'component': cause.component,
        'since': _s(period.shown_us(now_us) - now_us + live.stopped.since_us),
    }


def _s(us: Fraction | int | None) -> float | None:
    return None if us is None else round(float(us) / US, 3)


def _ratio(value: Fraction | None) -> float | None:
    return None if value is None else round(float(value), 6)
