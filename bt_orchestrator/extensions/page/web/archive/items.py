"""The record of one item."""

from __future__ import annotations

import json
from typing import Any

from bt_orchestrator.extensions.page.web.archive.archive import Look
from bt_orchestrator.extensions.page.web.archive.scanning import events
from bt_orchestrator.extensions.page.web.wording import said_in_each
from bt_orchestrator.model import events as e
from bt_orchestrator.model.records import Wanted
from bt_orchestrator.view.report.item.history import plain_item
from bt_orchestrator.view.report.item.reader import item_history
from bt_orchestrator.view.report.reading import Reading

_IDENTIFIED = (e.ItemIdentified.event,)


def item_record(look: Look, item: str) -> dict[str, Any] | None:
    """Return everything about an item; None: nothing is known of it."""
    history = item_history(reading(look), item)
    if history is None:
        return None
    begun, plain = history.started is not None, plain_item(history)
    for task in plain['tasks']:
        task['said'] = said_in_each(task['message'])
    return {**plain, 'damage': look.damage, 'has_beginning': begun}


def reading(look: Look) -> Reading:
    """Return what reads the records; damage is noted in the look."""
    return Reading(look.records, look.damage.append)


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
