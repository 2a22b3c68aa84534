"""A live account as one line for a terminal, and as plain data."""

from __future__ import annotations

from typing import Any

from bt_orchestrator.view.report.account.calendar import Turn
from bt_orchestrator.view.report.account.figures import LACKS
from bt_orchestrator.view.report.account.live import Live
from bt_orchestrator.view.report.account.losses import WORDS
from bt_orchestrator.view.report.account.plain import account_plain
from bt_orchestrator.view.report.account.standing import Cause
from bt_orchestrator.view.report.account.words import percent


def live_plain(live: Live) -> dict[str, Any]:
    """Return what a report says, and what goes on."""
    period, next_one, stopped = live.account.period, live.now.next, live.stopped
    return {
        **account_plain(live.account),
        'runs': live.runs,
        'ends': period.iso(live.now.period.end_us) if live.now.turn else None,
        'next': None if next_one is None else _turn(next_one),
        'stopped': None
        if stopped is None
        else {
            'loss': stopped.cause.loss.value,
            'detail': stopped.cause.detail,
            'component': stopped.cause.component,
            'hold': stopped.cause.hold or None,
            'since': period.iso(stopped.since_us),
        },
    }


def live_line(live: Live) -> str:
    """Return the most important of it on one line."""
    period, shown, stopped = live.account.period, live.account.figures, live.stopped
    factors = ' x '.join(map(percent, (shown.availability, shown.performance, shown.quality)))
    said = [
        f'{period.clock(period.end_us)}  {period.name}: OEE {percent(shown.oee)} = {factors}',
        f'made {shown.produced}, {shown.good} of them good',
    ]
    if shown.lack is not None:
        said.append(LACKS[shown.lack])
    if stopped is not None:
        said.append(f'{cause_words(stopped.cause)} since {period.clock(stopped.since_us)}')
    if not live.runs:
        said.append(over_words(live))
    return ', '.join(said)


def cause_words(cause: Cause) -> str:
    """Say what time is lost to, with its component."""
    about = cause.detail
    if cause.component not in about:
        about = f'{cause.component}, {about}'
    return ', '.join(filter(None, (WORDS[cause.loss].title, about)))


def over_words(live: Live) -> str:
    """Say that no shift runs, and when the next one begins."""
    next_one = live.now.next
    if next_one is None:
        return 'it is over'
    return f'it is over; {next_one.shift} begins {next_one.period.when(next_one.period.begin_us)}'


def _turn(turn: Turn) -> dict[str, Any]:
    return {'shift': turn.shift, 'begins': turn.period.iso(turn.period.begin_us)}
