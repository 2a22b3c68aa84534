"""The record of one item."""

from __future__ import annotations

import json
from typing import Any

from bt_orchestrator.model import events as e
from bt_orchestrator.model.codec import to_plain
from bt_orchestrator.model.records import Wanted
from bt_orchestrator.report.item_history import FOLLOWED, ItemFold
from bt_orchestrator.web.archive.archive import Look
from bt_orchestrator.web.archive.scanning import events, events_of_job

_OF_JOBS = (e.JobQueued.event, e.JobUpdated.event)
_IDENTIFIED = (e.ItemIdentified.event,)
_ANSWERS = (e.OperatorDecided.event, e.HoldReleased.event)


def item_record(look: Look, item: str) -> dict[str, Any] | None:
    """Return everything about an item; None: nothing is known of it."""
    job = item.rpartition('/')[0]
    fold, name = ItemFold(item, job), json.dumps(item, ensure_ascii=False)

    def may_be(text: str) -> bool:
        return name in text or '\\' in text or any(event in text for event in _OF_JOBS)

    for event in events_of_job(look, job, FOLLOWED, may_be):
        fold.follow(event)
    for hold in list(fold.history.holds):
        _decide(look, fold, hold.id, hold.seq)
    _remove(look, fold, item)
    if not fold.is_known:
        return None
    plain: dict[str, Any] = to_plain(fold.history, whole=True)
    plain['decisions'].sort(key=lambda one: one['time'])
    begun = fold.history.started is not None
    return {**plain, 'waits': [], 'damage': look.damage, 'has_beginning': begun}


def items_of(look: Look, serial: str) -> dict[str, Any]:
    """Return the items of a serial, the newest first."""
    wanted, serial = Wanted(events=_IDENTIFIED, newest_first=True), serial.strip()
    name = json.dumps(serial, ensure_ascii=False)
    found = [
        {'item': event.item, 'job': event.job, 'time': event.time}
        for event in events(look, wanted, lambda text: name in text or '\\' in text)
        if isinstance(event, e.ItemIdentified) and event.serial == serial
    ]
    return {'items': found, 'damage': look.damage, 'has_beginning': False}


def _decide(look: Look, fold: ItemFold, hold: str, after: int) -> None:
    """Take in what was decided about a hold, up to its end."""
    for event in events(look, Wanted(after_seq=after, events=_ANSWERS)):
        if getattr(event, 'hold', None) != hold:
            continue
        if not isinstance(event, e.OperatorDecided):
            return
        fold.decided(event)


def _remove(look: Look, fold: ItemFold, item: str) -> None:
    """Take in who took the item off the belt by hand: that stands just before its end."""
    history = fold.history
    if history.how != 'by_hand' or history.ended is None:
        return
    wanted = Wanted(since=history.ended, until=history.ended, events=_ANSWERS[:1])
    for event in events(look, wanted):
        if isinstance(event, e.OperatorDecided) and event.item == item:
            fold.decided(event)
