"""Scans of the records, limited so that nobody waits for a long journal."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator

from bt_orchestrator.model.codec import known_event
from bt_orchestrator.model.events import Event
from bt_orchestrator.model.records import Record, Wanted
from bt_orchestrator.web.archive.archive import Look

PAGE = 1000


def each(look: Look, wanted: Wanted) -> Iterator[Record]:
    """Yield the wanted records; what is damaged is noted."""
    is_last = False
    while not is_last:
        page = look.records.page(wanted, PAGE)
        look.note(list(page.damage))
        yield from page.records
        wanted, is_last = page.rest, page.is_last


def events(
    look: Look, wanted: Wanted, may_be: Callable[[str], bool] = lambda _: True
) -> Iterator[Event]:
    """Yield the wanted events that this program knows.

    :param may_be: looks at the text of a record, before it is read
    """
    for record in each(look, wanted):
        event = event_of(record) if may_be(record.text) else None
        if event is not None:
            yield event


def event_of(record: Record) -> Event | None:
    """Return the event of a record; None: this program does not know it."""
    return known_event(json.loads(record.text))
