"""Keeps the account of the shift that runs, read in a thread of its own."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from fractions import Fraction
from functools import partial
from typing import Any

from bt_orchestrator.base.errors import JournalUnusable
from bt_orchestrator.extensions.page.web.archive.archive import Archive, Look
from bt_orchestrator.extensions.page.web.offers import classify_offer
from bt_orchestrator.extensions.page.web.seams import Plant
from bt_orchestrator.model.plant.shifts import PlantReason
from bt_orchestrator.view.report.account.account import Account
from bt_orchestrator.view.report.account.calendar import Now, Turn, day_columns, shift_at, today
from bt_orchestrator.view.report.account.live import Live, LiveAccount
from bt_orchestrator.view.report.account.losses import Loss
from bt_orchestrator.view.report.account.planned import US
from bt_orchestrator.view.report.beside import Beside, beside
from bt_orchestrator.view.report.line_stops import LineStop, shares
from bt_orchestrator.view.report.reading import Reading

log = logging.getLogger(__name__)

MOST_STOPS = 50
"""Stops that the page lists: the longest."""

EVERY_S, SOON_S = 5.0, 1.0
"""Time between two looks at what is new; and while there is no account."""


class ShiftWatch:
    """All but the reading happens in the loop's thread."""

    def __init__(self, plant: Plant | None, archive: Archive, tell: Callable[[], object]) -> None:
        """Prepare.

        :param plant: None: there is no account
        :param archive: of its own, so that nobody waits for a long reading; it is closed here
        :param tell: called after each look that found something
        """
        self.is_wanted = plant is not None
        self.live: Live | None = None
        """As it was a moment ago; None: there is none, and `why_not` says why."""
        self.why_not = 'nothing was read yet'
        """The missing part; empty: nothing is missing."""
        self.is_reading = True
        """The first look has not ended: of a journal without books it takes some seconds."""
        self._archive = archive
        self._tell = tell
        self._plant = plant
        if plant is not None:
            self._account = LiveAccount(partial(_shift_at, plant), plant.cell, _quiet)

    async def run(self) -> None:
        """Look again and again, until it is cancelled."""
        while self.is_wanted:
            try:
                await self.look()
            except Exception:
                log.exception('the account of the shift cannot be computed')
                self.live, self.why_not = None, 'the page has an error, which is in its log'
            self._tell()
            await asyncio.sleep(SOON_S if self.live is None else EVERY_S)

    async def look(self) -> None:
        """Read what is new."""
        try:
            self.live, self.why_not = await self._archive.read(self._read)
        except JournalUnusable as error:
            self.live, self.why_not = None, str(error)
        finally:
            self.is_reading = False

    async def days(self, count: int) -> Beside:
        """Read the accounts of the last days, today as far as it has gone.

        :raises NothingToReport: the journal has nothing of them
        :raises JournalUnusable: it cannot be read
        """
        plant = self._plant
        assert plant is not None, 'there are no shifts'
        now = time.time()
        days = day_columns(plant.shifts, today(plant.shifts, now), count, now)
        columns = [(title, replace(day, reasons=plant.reasons)) for title, day in days]

        def read(look: Look) -> Beside:
            return beside(Reading(look.records, _quiet), columns, plant.cell)

        return await self._archive.read(read)

    def parts(self) -> Mapping[str, object]:
        """Return what the page shows; nothing if it knows no shifts."""
        if not self.is_wanted:
            return {}
        shift = {**shift_part(self.live, self.why_not), 'is_reading': self.is_reading}
        return {'shift': shift, **stops_part(self.live)}

    def close(self) -> None:
        """End the thread."""
        self._archive.close()

    def _read(self, look: Look) -> tuple[Live | None, str]:
        """Look; called in the thread that reads."""
        live = self._account.look(look.records, time.time())
        if live is None:
            return None, 'the journal has no event yet'
        lost = live.account.figures.times.lost_us
        is_whole = not lost.get(Loss.NOT_RECORDED)
        return live, self._archive.why_not_whole(look.extent, has_beginning=is_whole)


def _shift_at(plant: Plant, time: float) -> Now:
    now = shift_at(plant.shifts, time)
    return now._replace(period=replace(now.period, reasons=plant.reasons))


def _quiet(_: str) -> None:
    """Say nothing of damage: the account says how many records it lacks."""


# The account of the shift that runs as a part of the page: numbers, and no words but names.


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
            {'begin': _s(pause.begin_us), 'end': _s(pause.end_us), 'usual_s': _s(pause.usual_us)}
            for pause in period.changed_breaks
        ],
        'why_not': why_not,
    }


def stops_part(live: Live | None) -> dict[str, Any]:
    """Return the stops of the shift one by one; nothing if there is no shift."""
    if live is None or live.now.turn is None:
        return {}
    account, stopped = live.account, live.stopped
    times = account.figures.times
    longest = sorted(times.line_stops, key=lambda stop: -stop.us)[:MOST_STOPS]
    now = '' if stopped is None else stopped.stop
    return {
        'stops': {
            'stops': [
                _stop(account, stop, stands=account.stop_name(stop) == now)
                for stop in sorted(longest, key=lambda stop: -stop.span.since_us)
            ],
            'is_cut': times.line_stops_count > len(longest),
            'reasons': [
                {'code': share.code or None, 'times': share.times, 'seconds': round(share.us / US)}
                for share in shares(times.by_reason)
            ],
            'not_classified': _rounded(account.figures.not_classified),
            'offer': classify_offer(),
        }
    }


def _stop(account: Account, stop: LineStop, *, stands: bool) -> dict[str, Any]:
    """Return a stop, without what grows while it stands: it would be sent again and again."""
    span, reason, shown_us = stop.span, stop.reason, account.period.shown_us
    return {
        'stop': account.stop_name(stop),
        'loss': span.loss.value,
        'detail': span.detail,
        'component': span.component,
        'begin': _s(shown_us(span.since_us)),
        'end': None if stands else _s(shown_us(span.until_us)),
        'seconds': None if stands else _s(stop.us),
        'code': None if reason is None else reason.code,
        'by': '' if reason is None else reason.who,
        'why': '' if reason is None else reason.why,
    }


def _rounded(share: Fraction | None) -> float | None:
    return None if share is None else round(float(share), 2)


def reason_part(reasons: Mapping[str, PlantReason]) -> dict[str, Any]:
    """Return the reasons that forms offer; nothing if the page knows none."""
    each = [
        {'code': reason.code, 'words': dict(reason.words), 'group': reason.group}
        for reason in reasons.values()
    ]
    return {'reasons': each} if each else {}


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
